// Prints the sender of the frame after a byte of noise.
#include <ano/address.hpp>
#include <ano/parser.hpp>

#include <algorithm>
#include <cstdio>
#include <string>

int main() {
    const std::uint8_t bytes[] = {0x00, 0xAB, 0xFE, 0xFF, 0xE0, 0x03, 0x00, 0x00, 0x00, 0x00, 0x8B, 0x3B};
    ano::FrameParser parser{{}};
    std::copy(std::begin(bytes), std::end(bytes), parser.prepare().begin());
    parser.commit(sizeof bytes, ano::Clock::now());
    const auto frame = parser.next();
    if (!frame) return 1;
    std::printf("%02X from the %s\n", frame->id(), std::string{ano::address::who(frame->source())}.c_str());
}
