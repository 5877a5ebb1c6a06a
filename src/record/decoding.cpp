#include <ano_json/compact_json.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/strict_json.hpp>
#include <gateway/settings.hpp>
#include <record/decoding.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anogate {
namespace {

constexpr std::pair<LinkTexts, std::string_view> encoding_words[] = {
    {LinkTexts::utf8, "utf8"}, {LinkTexts::gbk, "gbk"}, {LinkTexts::expect_gbk, "expect_gbk"}};

std::map<std::string, LinkTexts, std::less<>> read_texts(const nlohmann::json& json) {
    std::map<std::string, LinkTexts, std::less<>> texts;
    if (!json.is_object()) return texts;
    for (const auto& [link, encoding_name] : json.items())
        for (const auto& [one, word] : encoding_words)
            if (encoding_name == word) texts.emplace(link, one);
    return texts;
}

std::optional<LinkTexts> texts_of(const LinkSettings& link) {
    if (link.encoding) return *link.encoding == TextEncoding::gbk ? LinkTexts::gbk : LinkTexts::utf8;
    return link.profile == Profile::vendor ? std::optional{LinkTexts::expect_gbk} : std::nullopt;
}

}    // namespace

std::string Decoding::text() const {
    ano::Json json = ano::Json::object();
    if (!flexible_.empty()) json["flexible"] = ano::flexible_to_json(flexible_);
    for (const std::string& link : lx_) json["attitude"][link] = "lx";
    for (const auto& [link, texts] : texts_)
        for (const auto& [one, word] : encoding_words)
            if (one == texts) json["encoding"][link] = word;
    return ano::compact_json(json);
}

DecodingPtr Decoding::parse(std::string_view text) {
    const auto strict = ano::strict_json<nlohmann::json>(text);
    if (!strict || !strict->is_object()) return nullptr;
    const nlohmann::json& json = *strict;
    std::vector<ano::FlexibleSpec> flexible;
    if (json.contains("flexible") && !ano::read_flexible(json["flexible"], "/flexible", flexible).empty()) return nullptr;
    std::set<std::string, std::less<>> lx;
    if (const auto attitude = json.find("attitude"); attitude != json.end() && attitude->is_object())
        for (const auto& [link, signs] : attitude->items())
            if (signs == "lx") lx.insert(link);
    return std::make_shared<const Decoding>(std::move(flexible), std::move(lx),
                                            read_texts(json.value("encoding", nlohmann::json{})));
}

bool decode_alike(const DecodingPtr& a, const DecodingPtr& b) {
    if (a == b) return true;
    if (!a || !b) return a ? a->is_usual() : b->is_usual();
    return *a == *b;
}

DecodingPtr decoding_of(const Settings& settings, std::vector<ano::FlexibleSpec> flexible) {
    std::set<std::string, std::less<>> lx;
    std::map<std::string, LinkTexts, std::less<>> texts;
    for (const LinkSettings& link : settings.links) {
        if (link.attitude == ano::EulerSigns::lx) lx.insert(link.name);
        if (const auto of_link = texts_of(link)) texts.emplace(link.name, *of_link);
    }
    return std::make_shared<const Decoding>(std::move(flexible), std::move(lx), std::move(texts));
}

}    // namespace anogate
