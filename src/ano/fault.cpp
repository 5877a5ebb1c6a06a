#include <ano/fault.hpp>

namespace ano {

std::string Fault::text() const {
    if (row_ == nullptr) return {};
    const ArgumentNames all = names();
    const std::string_view form = row_->english;
    std::string text;
    std::size_t at = 0;
    for (Placeholder next = placeholder_in(form, at); !next.name.empty(); next = placeholder_in(form, at)) {
        const std::string value = arguments_[all.index(next.name)].to_string();
        text.append(form, at, next.begin - at);
        text += next.many.empty() ? std::string_view{value} : value == "1" ? next.one : next.many;
        at = next.end;
    }
    text.append(form, at);
    for (const Fault& remark : remarks_) text.append("; ").append(remark.text());
    return text;
}

Fault::Argument::Argument(Fault its_fault) {
    const bool is_text = its_fault.id() == "other" && its_fault.remarks().empty();
    if (is_text) text = its_fault.text();
    else if (!its_fault.empty()) fault.push_back(std::move(its_fault));
}

Fault& Fault::add(Fault remark) {
    if (row_ == nullptr) *this = std::move(remark);
    else if (!remark.empty()) remarks_.push_back(std::move(remark));
    return *this;
}

Fault Fault::converted(const std::function<std::string(std::string_view text)>& convert) const {
    Fault result = *this;
    for (Argument& argument : result.arguments_)
        if (argument.fault.empty()) argument.text = convert(argument.text);
        else argument.fault.front() = argument.fault.front().converted(convert);
    for (Fault& remark : result.remarks_) remark = remark.converted(convert);
    return result;
}

}    // namespace ano
