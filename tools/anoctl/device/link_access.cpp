#include "link_access.hpp"

#include "kept_values.hpp"

#include <ano/address.hpp>
#include <anoctl/own_link.hpp>
#include <config/wire.hpp>
#include <devices/device_net.hpp>
#include <devices/device_routes.hpp>
#include <devices/device_service.hpp>
#include <http/asio.hpp>
#include <http/producer.hpp>
#include <http/response.hpp>
#include <http/routes.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
namespace http = anogate::http;
using ano::TimePoint;
using anogate::error_code;

constexpr auto time_to_open = std::chrono::seconds{5};    // for the link to be up; then requests fail

anogate::DeviceLimits device_limits_of(const anogate::LinkSettings& settings) {
    anogate::DeviceLimits device_limits;
    device_limits.text.max_bytes = settings.max_text();
    device_limits.expects_gbk = settings.profile == anogate::Profile::vendor;
    device_limits.value_type_7 = settings.stated_type_7();
    if (settings.encoding)
        device_limits.encoding = *settings.encoding == anogate::TextEncoding::gbk ? ano::Encoding::gbk : ano::Encoding::utf8;
    device_limits.by_number = uses_v7(settings);
    device_limits.max_data = std::min<std::size_t>(device_limits.max_data, settings.effective_max_data_out());
    return device_limits;
}

std::string utc_text(std::time_t time) {
    std::tm parts{};
    ::gmtime_r(&time, &parts);
    char text[32];
    return std::string{text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

// Implements DeviceNet for the host engine with a single link.
class LinkNet final : public anogate::DeviceNet, public FrameReceiver {
public:
    LinkNet(asio::io_context& io, const anogate::LinkSettings& settings, Streams& streams, std::optional<std::uint8_t> there)
        : timer_{io},
          there_{there},
          device_limits_{device_limits_of(settings)},
          wire_{anogate::wire_of(settings)},
          link_{io, settings, *this, streams, ""},
          service_{*this} {
        anogate::add_device_routes(routes_, service_);
        service_.keep_descriptions();
        for (auto& [name, text] : texts_in_state_folder(anogate::is_type_7_note)) service_.remember(name, std::move(text));
        link_.start();
    }
    ~LinkNet() override {
        service_.stop(now());
        link_.stop();
    }

    const http::Routes& routes() const noexcept { return routes_; }
    bool is_up() const noexcept { return link_.is_up(); }
    const std::string& name() const noexcept { return link_.name(); }

private:
    struct Heard {
        std::string peer;
        std::optional<TimePoint> at{};
        bool elsewhere = false;    // received from two peers, so the right one is not known
    };

    bool accept(ano::FrameView frame, const Passage& passage) override {
        const TimePoint time = now();
        Heard& heard = heard_[frame.source()];
        heard.elsewhere = heard.elsewhere || (heard.at && heard.peer != passage.link);
        heard.peer = passage.link;
        heard.at = time;
        if (listens_) service_.receive(frame, time);
        return true;
    }
    bool flush() override { return true; }
    void miss(std::uint64_t, const std::string&, std::string_view) override {}

    TimePoint now() override { return ano::Clock::now(); }
    anogate::Unsent send(ano::FrameView frame) override {
        link_.send(frame);
        return {};
    }
    ano::Flush flush_parser(ano::FrameView next) override { return link_.flush_parser(next); }
    bool is_waiting(std::uint8_t) override { return link_.waiting() > 0; }
    void listen(bool wants) override { listens_ = wants; }
    void wake(TimePoint at) override {
        if (wakes_at_ && *wakes_at_ <= at) return;
        wakes_at_ = at;
        timer_.expires_at(at);
        timer_.async_wait([this](error_code ec) {
            if (ec) return;
            wakes_at_.reset();
            service_.run(now());
        });
    }
    std::vector<anogate::HeardAddress> heard(TimePoint) override {
        std::vector<anogate::HeardAddress> all;
        for (unsigned address = 1; address < 255; ++address) {
            const Heard& one = heard_[address];
            if (one.at && !ano::address::is_host(static_cast<std::uint8_t>(address)))
                all.push_back(
                    {static_cast<std::uint8_t>(address), link_.name(), one.peer == link_.name() ? "" : one.peer, one.at});
        }
        return all;
    }
    ano::host::RouteInfo route_info(std::uint8_t address, TimePoint) override {
        const Heard& one = heard_[address];
        return {one.at.has_value() || address == there_, false, one.elsewhere};
    }
    void keep(std::string name, std::string text, std::function<void(std::string fault)> done) override {
        const std::string fault = keep_in_state_folder(name, text, kept_.contains(name) ? Earlier::replaced : Earlier::stays);
        if (fault.empty() && !text.empty()) kept_.insert(name);
        if (text.empty()) kept_.erase(name);
        done(fault);
    }
    std::string kept_path(const std::string& name) override { return path_in_state_folder(name); }
    anogate::UnitPlace unit_place(std::uint8_t, TimePoint) override { return {"anoctl --link", link_.name(), wire_}; }
    std::string cached(const std::string& name) override { return cached_text(name); }
    void cache(const std::string& name, const std::string& text) override { cache_text(name, text); }
    std::string date_text() override { return utc_text(std::time(nullptr)); }
    std::string way_to_write_back(const std::string& name) override {
        return "restore them with: anoctl param import " + path_in_state_folder(name) + " --link LINK";
    }
    anogate::DeviceLimits device_limits(std::uint8_t) override { return device_limits_; }

    asio::steady_timer timer_;
    std::optional<TimePoint> wakes_at_;
    std::array<Heard, 256> heard_;
    std::set<std::string> kept_;    // files written by this run
    bool listens_ = false;
    const std::optional<std::uint8_t> there_;
    const anogate::DeviceLimits device_limits_;
    const std::string wire_;
    OwnLink link_;
    anogate::DeviceService service_;
    http::Routes routes_;
};

/// A response in progress. Ends when it is complete or was dropped.
class Answering : public std::enable_shared_from_this<Answering> {
public:
    Answering(asio::io_context& io, DeviceAccess::Line line, DeviceAccess::Done done)
        : io_{io}, line_{std::move(line)}, done_{std::move(done)} {}

    void accept(http::Response response) {
        if (!done_) return;
        if (response.later) {
            needed_ = response.needed;
            const auto later = std::move(response.later);
            return later([self = weak_from_this()](http::Response made) {
                if (const auto here = self.lock())
                    asio::post(here->io_, [here, kept = std::make_shared<http::Response>(std::move(made))] {
                        here->accept(std::move(*kept));
                    });
            });
        }
        answer_.status = response.status;
        answer_.headers = {{"Content-Type", response.type}};
        answer_.body = response.pop_text();
        producer_ = std::move(response.producer);
        if (!producer_) return finish();
        producer_->start([self = weak_from_this()] {
            if (const auto here = self.lock()) here->go_on_soon();
        });
        go_on_soon();
    }
    void drop() {
        done_ = {};
        line_ = {};
        producer_.reset();
        needed_.reset();
    }

private:
    void go_on_soon() {
        if (std::exchange(goes_on_, true)) return;
        asio::post(io_, [self = shared_from_this()] {
            self->goes_on_ = false;
            self->go_on();
        });
    }
    void go_on() {
        while (producer_) {
            std::string part;
            const auto next = producer_->next(part);
            receive(part);
            if (next == http::Producer::Next::later) return;
            if (next == http::Producer::Next::end) return finish();
        }
    }
    void receive(const std::string& part) {
        if (!line_) {
            answer_.body += part;
            return;
        }
        rest_ += part;
        std::size_t begin = 0;
        for (std::size_t end = 0; line_ && (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1)
            line_(std::string_view{rest_}.substr(begin, end - begin));
        rest_.erase(0, begin);
    }
    void finish() {
        const auto done = std::move(done_);
        drop();
        if (done) done({{}, std::move(answer_)});
    }

    asio::io_context& io_;
    DeviceAccess::Line line_;
    DeviceAccess::Done done_;
    http::Answer answer_;
    std::unique_ptr<http::Producer> producer_;
    std::shared_ptr<void> needed_;
    std::string rest_;
    bool goes_on_ = false;
};

class LinkAccess final : public DeviceAccess {
public:
    LinkAccess(asio::io_context& io, const anogate::LinkSettings& settings, Streams& streams, std::optional<std::uint8_t> there)
        : io_{io}, patience_{io}, net_{io, settings, streams, there} {}
    ~LinkAccess() override { LinkAccess::hang_up(); }

    void ask(http::Request request, Done done) override { begin(asks_, std::move(request), {}, std::move(done)); }
    void stream(http::Request request, Line line, Done done) override {
        begin(streams_, std::move(request), std::move(line), std::move(done));
    }
    void hang_up() override {
        for (auto* one : {&asks_, &streams_})
            if (const auto answering = std::exchange(*one, nullptr)) answering->drop();
    }

private:
    void begin(std::shared_ptr<Answering>& place, http::Request request, Line line, Done done) {
        if (place) place->drop();
        place = std::make_shared<Answering>(io_, std::move(line), std::move(done));
        if (opened_by_ == TimePoint{}) opened_by_ = ano::Clock::now() + time_to_open;
        when_open(place, std::move(request));
    }
    // Waits until the link is up, because no device can respond before.
    void when_open(const std::shared_ptr<Answering>& answering, http::Request request) {
        if (net_.is_up() || ano::Clock::now() >= opened_by_) {
            asio::post(io_, [this, answering, request = std::move(request)]() mutable {
                if (!net_.is_up()) return answering->accept(http::error(504, net_.name() + " is not available"));
                request.came_at = ano::Clock::now();
                answering->accept(net_.routes().answer(std::move(request)));
            });
            return;
        }
        patience_.expires_after(std::chrono::milliseconds{10});
        patience_.async_wait([this, answering, request = std::move(request)](error_code ec) mutable {
            if (!ec) when_open(answering, std::move(request));
        });
    }

    asio::io_context& io_;
    asio::steady_timer patience_;
    LinkNet net_;
    TimePoint opened_by_{};
    std::shared_ptr<Answering> asks_, streams_;
};

}    // namespace

std::unique_ptr<DeviceAccess> link_access(asio::io_context& io, const anogate::LinkSettings& settings, Streams& streams,
                                          std::optional<std::uint8_t> there) {
    return std::make_unique<LinkAccess>(io, settings, streams, there);
}

}    // namespace anoctl
