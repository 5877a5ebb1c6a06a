#include <ano_json/text.hpp>
#include <devices/device_service.hpp>
#include <devices/job_answers.hpp>
#include <devices/works/parameter_works.hpp>
#include <foxglove/foxglove_socket.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <link/clocks.hpp>
#include <runtime/gateway.hpp>
#include <watch/watched_record.hpp>

#include <algorithm>
#include <new>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t old_results = 256 * 1024;    // bytes of earlier job results that are read for the first client
constexpr std::size_t max_devices = 8;             // queried for one request

foxglove::ServerInfo server_of(const Settings& settings) {
    const auto started = std::chrono::duration_cast<std::chrono::milliseconds>(read_clocks().real);
    return {settings.gateway.name, std::to_string(started.count())};
}

}    // namespace

struct FoxgloveStreams::Question {
    unsigned client;    // its number; it may be disconnected
    foxglove::GetParameters asked;
    std::size_t open = 0;    // devices without an answer yet
    Requester requester{};
    std::shared_ptr<void> place{};    // held: one of the places for clients that wait for jobs
};

bool is_foxglove(const http::Request& request) noexcept {
    return http::is_web_socket(request) && !http::offered_subprotocol(request, foxglove::subprotocols).empty();
}

FoxgloveStreams::FoxgloveStreams(Gateway& gateway, FrameWatch& watch, DeviceService& devices)
    : gateway_{gateway}, watch_{watch}, devices_{devices}, decoding_{gateway.decoding()}, server_{server_of(gateway.settings())} {
    devices_.on_end([this](const Job& job) { ended(job); });
}

FoxgloveStreams::~FoxgloveStreams() {
    devices_.on_end({});
    if (!sockets_.empty()) watch_.remove(*this);
}

http::Response FoxgloveStreams::answer(const http::Request& request) {
    if (http::Response fault = http::web_socket_fault(request); fault.status != 200) return fault;
    const std::string_view subprotocol = http::offered_subprotocol(request, foxglove::subprotocols);
    if (subprotocol.empty()) return http::error(400, "this path needs the subprotocol foxglove.sdk.v1 or foxglove.websocket.v1");
    const std::string_view encoding = request.query_value("encoding").value_or(text(DecodedEncoding::cdr));
    const bool is_json = encoding == text(DecodedEncoding::json);
    if (!is_json && encoding != text(DecodedEncoding::cdr))
        return http::error(400, "'encoding' must be cdr or json, not " + ano::in_quotes(encoding));
    http::Response response;
    response.web_socket = std::make_unique<FoxgloveSocket>(
        *this, ++clients_, subprotocol, is_json ? DecodedEncoding::json : DecodedEncoding::cdr, requester_of(request, false));
    return response;
}

void FoxgloveStreams::join(FoxgloveSocket& socket) {
    if (!sockets_.empty() && decoding_ != gateway_.decoding()) renew_decoding();
    sockets_.push_back(&socket);
    if (sockets_.size() == 1) {
        decoding_ = gateway_.decoding();
        as_cdr_.emplace(DecodedEncoding::cdr, decoding_);
        as_json_.emplace(DecodedEncoding::json, decoding_);
        read_old_jobs();
        FrameFilterSettings samples;
        samples.directions = {true, false, false};
        samples.samples = 2;
        samples.elsewhere = false;
        watch_.add(*this, samples);
    }
    socket.use(decoding_);
    for (const FirstFrame& first : found(socket.encoding()).first_frames()) socket.learn(first);
}

void FoxgloveStreams::leave(FoxgloveSocket& socket) {
    std::erase(sockets_, &socket);
    if (!sockets_.empty()) return;
    watch_.remove(*this);
    as_cdr_.reset();
    as_json_.reset();
    book_.forget();
}

FoxgloveSocket* FoxgloveStreams::client(unsigned number) const {
    const auto found = std::find_if(sockets_.begin(), sockets_.end(), [&](const auto* one) { return one->number() == number; });
    return found == sockets_.end() ? nullptr : *found;
}

// Lost frames are not reported: later samples of the same kind show the same channels.
void FoxgloveStreams::more() try {
    if (decoding_ != gateway_.decoding()) renew_decoding();
    while (auto item = queue.next(Clock::now())) {
        if (auto* tables = std::get_if<WatchQueue::Tables>(&*item)) look_at(std::move(*tables));
        const auto* batch = std::get_if<WatchQueue::Batch>(&*item);
        if (batch == nullptr) continue;
        std::string_view rest = **batch;
        while (const auto record = next_record(rest)) look_at(as_recorded(*record, *tables_));
    }
} catch (const std::bad_alloc&) {
    return;
}

void FoxgloveStreams::renew_decoding() {
    decoding_ = gateway_.decoding();
    for (const DecodedEncoding encoding : {DecodedEncoding::cdr, DecodedEncoding::json}) found(encoding).use(decoding_);
    for (FoxgloveSocket* const socket : sockets_) socket->use(decoding_);
}

FoundChannels& FoxgloveStreams::found(DecodedEncoding encoding) {
    return encoding == DecodedEncoding::cdr ? *as_cdr_ : *as_json_;
}

void FoxgloveStreams::look_at(const RecordedFrame& frame) {
    for (const DecodedEncoding encoding : {DecodedEncoding::cdr, DecodedEncoding::json}) {
        const FirstFrame* const first = found(encoding).look_at(frame);
        if (first == nullptr) continue;
        for (FoxgloveSocket* const socket : sockets_)
            if (socket->encoding() == encoding) socket->learn(*first);
    }
}

// Forgets the channels of removed links.
void FoxgloveStreams::look_at(WatchQueue::Tables tables) {
    const WatchQueue::Tables before = std::exchange(tables_, std::move(tables));
    if (!before) return;
    const std::vector<std::string>& now = tables_->links;
    for (const std::string& link : before->links) {
        if (link.empty() || std::find(now.begin(), now.end(), link) != now.end()) continue;
        for (const DecodedEncoding encoding : {DecodedEncoding::cdr, DecodedEncoding::json}) found(encoding).forget(link);
        for (FoxgloveSocket* const socket : sockets_) socket->forget(link);
    }
}

std::string FoxgloveStreams::prefix_of(std::uint8_t address) {
    const auto all = devices_.net().heard(gateway_.now());
    const auto one = std::find_if(all.begin(), all.end(), [&](const HeardAddress& heard) { return heard.address == address; });
    return parameter_prefix(one == all.end() ? std::string_view{} : std::string_view{one->link}, address);
}

// The newest results are learned last, because they take precedence.
void FoxgloveStreams::read_old_jobs() {
    const auto& jobs = devices_.jobs();
    std::size_t size = 0;
    auto first = jobs.end();
    while (first != jobs.begin()) {
        if (const Job& job = **std::prev(first); has_parameters(job)) size += job.result->size();
        if (size > old_results) break;
        --first;
    }
    for (; first != jobs.end(); ++first)
        if (has_parameters(**first)) book_.learn(**first, prefix_of(*(*first)->order.address));
}

void FoxgloveStreams::ended(const Job& job) {
    if (sockets_.empty() || !has_parameters(job)) return;
    const auto values = book_.learn(job, prefix_of(*job.order.address));
    for (FoxgloveSocket* const socket : sockets_) socket->changed(values);
}

void FoxgloveStreams::ask(FoxgloveSocket& socket, foxglove::GetParameters asked) {
    if (asked.names.empty()) return socket.answer(asked, book_.all());
    if (!devices_.has_room_for(socket.requester())) {
        socket.warn("too many clients are waiting for devices; only the known parameters were sent, try again");
        return socket.answer(asked, book_.of(asked.names));
    }
    const auto question = std::make_shared<Question>(
        Question{socket.number(), std::move(asked), 1, socket.requester(), devices_.waiting_client(socket.requester())});
    std::vector<std::string> unknown = question->asked.names;
    std::size_t devices = 0;
    for (const HeardAddress& heard : devices_.net().heard(gateway_.now())) {
        const std::string prefix = parameter_prefix(heard.link, heard.address);
        const auto of_others = std::stable_partition(unknown.begin(), unknown.end(),
                                                     [&](const std::string& name) { return !name.starts_with(prefix); });
        std::vector<std::string> names;
        for (auto name = of_others; name != unknown.end(); ++name) names.push_back(name->substr(prefix.size()));
        unknown.erase(of_others, unknown.end());
        if (names.empty()) continue;
        if (++devices <= max_devices) ask_device(heard.address, std::move(names), question);
        else
            socket.warn("a request can read from at most " + std::to_string(max_devices) +
                        " devices; request the others separately");
    }
    if (!unknown.empty())
        socket.warn("no known device has " + ano::in_quotes(unknown.front()) + ": parameter names are LINK/ADDRESS/PARAMETER");
    answered(*question);
}

void FoxgloveStreams::ask_device(std::uint8_t address, std::vector<std::string> names,
                                 const std::shared_ptr<Question>& question) {
    JobOrder order{JobKind::parameters,
                   ano::host::Operation::read,
                   address,
                   false,
                   "a Foxglove client",
                   [names = std::move(names)](const WorkPlace& place) { return read_parameters(place, {.words = names}); }};
    order.requester = question->requester;
    const auto begun = devices_.begin(std::move(order), gateway_.now());
    if (const auto* refused = std::get_if<NotBegun>(&begun)) return warn(question->client, refused->fault.text());
    const auto& job = std::get<std::shared_ptr<Job>>(begun);
    job->goes_on = true;
    ++question->open;
    job->on_end.push_back([this, question, life = std::weak_ptr{life_}](const Job& ended) {
        if (life.expired()) return;
        if (!ended.message.empty()) warn(question->client, ended.message);
        answered(*question);
    });
}

void FoxgloveStreams::answered(Question& question) {
    FoxgloveSocket* const socket = --question.open == 0 ? client(question.client) : nullptr;
    if (socket != nullptr) socket->answer(question.asked, book_.of(question.asked.names));
}

void FoxgloveStreams::warn(unsigned number, std::string_view words) {
    if (FoxgloveSocket* const socket = client(number)) socket->warn(words);
}

}    // namespace anogate
