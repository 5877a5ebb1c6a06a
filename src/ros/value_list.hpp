// The values of one message in the order of its fields, for CdrEncoder. clear() keeps the memory.
#pragma once
#include <ano/reading.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class ValueList {
public:
    void clear() noexcept {
        values_.clear();
        texts_used_ = 0;
    }
    /// Memory that `value` refers to must stay valid as long as the list is used.
    void push(const ano::Value& value) { values_.push_back(value); }
    void push(double value) { values_.emplace_back(value); }
    void push_count(std::size_t count) { values_.emplace_back(std::uint64_t{count}); }
    /// Copies a text into the list.
    void push_copy(std::string text) {
        if (texts_used_ == texts_.size()) texts_.emplace_back();
        std::string& kept = texts_[texts_used_++];
        kept = std::move(text);
        values_.emplace_back(std::string_view{kept});
    }
    /// Adds `size` bytes as one value and returns them; the caller must write them before the list is used.
    std::span<std::uint8_t> push_bytes(std::size_t size) {
        if (texts_used_ == texts_.size()) texts_.emplace_back();
        std::string& kept = texts_[texts_used_++];
        kept.resize(size);
        auto* const first = reinterpret_cast<std::uint8_t*>(kept.data());
        values_.emplace_back(ano::Bytes{first, size});
        return {first, size};
    }
    std::span<const ano::Value> values() const noexcept { return values_; }

private:
    std::vector<ano::Value> values_;
    std::deque<std::string> texts_;
    std::size_t texts_used_ = 0;
};

}    // namespace anogate
