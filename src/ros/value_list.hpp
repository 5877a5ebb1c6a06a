// The values of one message, in the order of its fields, for CdrEncoder. Keeps its memory.
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
    /// What it refers to outlives the list's use.
    void push(const ano::Value& value) { values_.push_back(value); }
    void push(double value) { values_.emplace_back(value); }
    void push_count(std::size_t count) { values_.emplace_back(std::uint64_t{count}); }
    /// A text that nobody else keeps.
    void push_copy(std::string text) {
        if (texts_used_ == texts_.size()) texts_.emplace_back();
        std::string& kept = texts_[texts_used_++];
        kept = std::move(text);
        values_.emplace_back(std::string_view{kept});
    }
    /// So many bytes, as one value, to be written before it is used.
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
