// Any DATA of any message: every field is read, and nothing after the end of DATA. The first byte is the id.
#include <ano/reading.hpp>
#include <ano/typed.hpp>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <variant>
#include <vector>

namespace {

using namespace ano;

void must(bool law) {
    if (!law) std::abort();
}

const FlexibleLayouts& layouts() {
    static const FlexibleLayouts all = [] {
        FlexibleLayouts made;
        const std::vector<FlexibleField> every{{"a", Type::u8, 0.5, ""}, {"b", Type::i16, 1, ""}, {"c", Type::f32, 3, ""}};
        must(!made.add(0xF1, std::nullopt, every));
        must(!made.add(0xF2, 7, every));
        return made;
    }();
    return all;
}

std::uint64_t sum = 0;

void use(const Value& value) {
    std::visit(
        [](const auto& v) {
            if constexpr (requires { v.size(); })
                for (const auto c : v) sum += static_cast<std::uint8_t>(c);
            else if constexpr (std::is_same_v<std::decay_t<decltype(v)>, double>) sum += std::isnan(v) ? 1u : 0u;
        },
        value);
}

// A scaled number is encoded back to the same bytes.
void check_number(const Field& f, const Value& value, const std::uint8_t* at) {
    std::uint8_t again[8];
    const auto store_again = [&]<class T>(T v) -> bool {
        if constexpr (std::is_arithmetic_v<T>) return store_number(f, Number{v}, again) == Stored::ok;
        else return store_no_data(f, again);
    };
    must(std::visit(store_again, value));
    if (is_integer(f.type))
        for (std::size_t i = 0; i < width(f.type); ++i) must(again[i] == at[i]);
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t input_size) {
    if (input_size == 0) return 0;
    const std::uint8_t id = input[0];
    const std::size_t size = input_size - 1;
    const auto data = std::make_unique<std::uint8_t[]>(size);    // exactly its size: a sanitizer detects a read of one byte more
    for (std::size_t i = 0; i < size; ++i) data[i] = input[i + 1];

    const Reading reading = read(id, {data.get(), size}, &layouts(), 7);
    must((reading.message() == nullptr) == (reading.readable() == Readable::unknown_id));
    if (!reading) return 0;
    std::size_t seen = reading.extra().size();
    for (const Field& f : reading.fields()) {
        const Value value = reading.value(f);
        use(value);
        if (is_number(f.type) && f.count == 1) check_number(f, value, data.get() + f.offset);
        seen += reading.bytes_of(f).size();
    }
    for (std::size_t i = 0; i < reading.element_count(); ++i)
        for (const Field& f : reading.element_fields()) use(reading.element(i, f));
    must(seen == size);
    return 0;
}
