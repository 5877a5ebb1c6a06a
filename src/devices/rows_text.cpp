#include <ano/hex.hpp>
#include <ano_json/json_line.hpp>
#include <devices/rows_text.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anogate {

using Json = nlohmann::ordered_json;

RowsText::RowsText(const Json& head, std::string_view list) : text_{ano::json_line(head)} {
    text_.resize(text_.size() - 2);    // "}\n"
    text_.append(",\"").append(list).append("\":[");
}

void RowsText::add(const Json& row) {
    if (!std::exchange(is_empty_, false)) text_ += ',';
    text_ += ano::json_line(row);
    text_.pop_back();
}

WorkEnd RowsText::ended(WorkEnd end, const Json& tail) {
    text_ += ']';
    if (!tail.empty()) {
        std::string members = ano::json_line(tail);
        members.front() = ',';
        members.pop_back();
        text_ += members;
    } else text_ += '}';
    end.result = std::move(text_);
    end.is_exact = true;
    return end;
}

WorkEnd too_many_bytes(std::uint8_t address) {
    return work_fault({"description_too_long", ano::hex_byte(address), RowsText::max_bytes >> 20});
}

}    // namespace anogate
