#include <client/frame_stream.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <utility>

namespace anogate {

using Json = nlohmann::json;

FrameStream::FrameStream(asio::io_context& io, std::string control, const std::string& filters, Events events)
    : events_{std::move(events)},
      socket_{io,
              std::move(control),
              "/frames?format=binary" + filters,
              {.opened = [this] { events_.opened(); },
               .received = [this](std::string_view message, http::WebSocket::Kind kind) { receive(message, kind); },
               .closed = [this](const std::string& why) { events_.closed(why); }}} {}

void FrameStream::receive(std::string_view message, http::WebSocket::Kind kind) {
    if (kind == http::WebSocket::Kind::text) return receive_text(message);
    while (const auto record = next_record(message))
        events_.frame({record->link < links_.size() ? std::string_view{links_[record->link]} : std::string_view{}, *record});
}

// A text message contains the names of the links and the decoding, or the number of lost frames.
void FrameStream::receive_text(std::string_view text) {
    const Json notice = Json::parse(text, nullptr, false);
    if (!notice.is_object()) return;
    if (notice.contains("lost") && notice["lost"].is_object()) {
        std::uint64_t count = 0;
        for (const auto& [name, number] : notice["lost"].items())
            if (number.is_number_unsigned()) count += number.get<std::uint64_t>();
        return events_.lost(count);
    }
    links_.clear();
    const Json links = notice.value("links", Json::array());
    for (const Json& name : links) links_.push_back(name.is_string() ? name.get<std::string>() : "");
    auto decoding = notice.contains("decoding") ? Decoding::parse(notice["decoding"].dump()) : nullptr;
    events_.decoding(decoding ? std::move(decoding) : std::make_shared<const Decoding>());
}

}    // namespace anogate
