#include <record/decoded_channels.hpp>

namespace anogate {

struct DecodedChannels::State {
    std::deque<DecodedSchema> schemas;
    std::deque<DecodedChannel> channels;
};

std::string_view text(DecodedEncoding encoding) noexcept { return encoding == DecodedEncoding::cdr ? "cdr" : "json"; }

DecodedChannels::DecodedChannels(DecodedEncoding) : state_{std::make_unique<State>()} {}
DecodedChannels::~DecodedChannels() = default;
std::span<const DecodedMessage> DecodedChannels::decode(const RecordedFrame&) { return {}; }
const std::deque<DecodedSchema>& DecodedChannels::schemas() const noexcept { return state_->schemas; }
const std::deque<DecodedChannel>& DecodedChannels::channels() const noexcept { return state_->channels; }

}    // namespace anogate
