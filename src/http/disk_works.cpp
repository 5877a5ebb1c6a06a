#include <http/disk_works.hpp>
#include <sys/asio.hpp>

#include <utility>

namespace anogate {

DiskWorks::DiskWorks(asio::io_context& io) : io_{io}, errands_{Errand{io}, Errand{io}, Errand{io}, Errand{io}} {}

DiskWorks::Ticket DiskWorks::run(std::function<void()> work, std::function<void(std::string)> done) {
    auto piece = std::make_shared<Piece>(Piece{std::move(work), std::move(done)});
    waiting_.push_back(piece);
    begin();
    return piece;
}

void DiskWorks::run_for_nobody(std::function<void()> work, std::function<void(std::string)> done) {
    unheld_.insert(run(std::move(work), std::move(done)));
}

void DiskWorks::begin() {
    for (Errand& errand : errands_) {
        while (!stopped_ && !errand.is_running() && !waiting_.empty()) {
            const auto piece = waiting_.front().lock();
            waiting_.pop_front();
            if (piece) begin(errand, piece);
        }
    }
}

void DiskWorks::begin(Errand& errand, const std::shared_ptr<Piece>& piece) {
    const auto told = [this, weak = std::weak_ptr{piece}](std::string fault) {
        if (const auto still = weak.lock()) tell(still, std::move(fault));
        begin();
    };
    if (errand.run(std::exchange(piece->work, nullptr), told)) return;
    asio::post(io_, [this, weak = std::weak_ptr{piece}, why = errand.why_not()] {
        if (const auto still = weak.lock()) tell(still, std::string{why} + " for the disk");
    });
}

void DiskWorks::tell(const std::shared_ptr<Piece>& piece, std::string fault) {
    unheld_.erase(piece);
    std::exchange(piece->done, nullptr)(std::move(fault));
}

void DiskWorks::stop() {
    stopped_ = true;
    waiting_.clear();
    unheld_.clear();
    const ano::TimePoint by = ano::Clock::now() + Errand::patience_at_the_end;    // one deadline for all threads
    for (Errand& errand : errands_) errand.stop(by);
}

http::Response answer_from(DiskWorks& disk, std::function<http::Response()> work) {
    const auto held = std::make_shared<DiskWorks::Ticket>();
    http::Response response = http::later(
        [&disk, work = std::move(work), weak = std::weak_ptr{held}](const std::function<void(http::Response)>& say) {
            const auto made = std::make_shared<http::Response>();
            DiskWorks::Ticket ticket = disk.run(
                [made, work] { *made = work(); },
                [made, say](const std::string& fault) { say(fault.empty() ? std::move(*made) : http::error(503, fault)); });
            if (const auto still = weak.lock()) *still = std::move(ticket);
        });
    response.patient = true;
    response.needed = held;
    return response;
}

}    // namespace anogate
