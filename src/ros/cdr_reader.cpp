#include <ros/cdr_reader.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace anogate {
namespace {

constexpr std::size_t header_size = 4;
constexpr std::uint8_t cdr_big = 0, cdr_little = 1;    // the second byte of the header; other encodings have other numbers

}    // namespace

CdrReader::CdrReader(ano::Bytes data) noexcept {
    is_good_ = data.size() >= header_size && data[0] == 0 && (data[1] == cdr_big || data[1] == cdr_little);
    if (!is_good_) return;
    is_big_endian_ = data[1] == cdr_big;
    data_ = data.subspan(header_size);
}

std::uint32_t CdrReader::u32() noexcept { return number<std::uint32_t>(); }
float CdrReader::f32() noexcept { return number<float>(); }
double CdrReader::f64() noexcept { return number<double>(); }

std::string_view CdrReader::text() noexcept {
    const ano::Bytes bytes = take(1, u32());
    if (bytes.empty()) return {};
    if (bytes.back() != 0) {
        is_good_ = false;
        return {};
    }
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1};
}

std::size_t CdrReader::count(std::size_t element) noexcept {
    const std::size_t count = u32();
    if (count > (data_.size() - at_) / element) is_good_ = false;
    return is_good_ ? count : 0;
}

template <class T>
T CdrReader::number() noexcept {
    const ano::Bytes bytes = take(sizeof(T), sizeof(T));
    if (bytes.empty()) return T{};
    std::array<std::uint8_t, sizeof(T)> ordered;
    std::copy(bytes.begin(), bytes.end(), ordered.begin());
    if (is_big_endian_) std::reverse(ordered.begin(), ordered.end());
    return ano::load<T>(ordered.data());
}

ano::Bytes CdrReader::take(std::size_t alignment, std::size_t size) noexcept {
    const std::size_t from = (at_ + alignment - 1) / alignment * alignment;
    if (!is_good_ || from > data_.size() || size > data_.size() - from) {
        is_good_ = false;
        return {};
    }
    at_ = from + size;
    return data_.subspan(from, size);
}

std::optional<Twist> read_twist(ano::Bytes cdr) {
    CdrReader reader{cdr};
    Twist twist;
    for (auto* part : {&twist.linear, &twist.angular})
        for (double& value : *part) value = reader.f64();
    return reader.is_good() ? std::optional{twist} : std::nullopt;
}

std::optional<Joy> read_joy(ano::Bytes cdr) {
    CdrReader reader{cdr};
    reader.u32();    // the stamp: seconds, nanoseconds
    reader.u32();
    reader.text();
    Joy joy;
    joy.axes.resize(reader.count(sizeof(float)));
    for (float& axis : joy.axes) axis = reader.f32();
    return reader.is_good() ? std::optional{std::move(joy)} : std::nullopt;
}

std::optional<std::string> read_string(ano::Bytes cdr) {
    CdrReader reader{cdr};
    std::string text{reader.text()};
    return reader.is_good() ? std::optional{std::move(text)} : std::nullopt;
}

}    // namespace anogate
