#include "chinese_texts.hpp"

#include <ano/frame.hpp>
#include <ano/reading.hpp>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <variant>

namespace ano::world {
namespace {

struct Translation {
    std::string_view english, chinese, info;
};

// clang-format off
constexpr Translation translations[]{
    {"SimFC", "模拟飞控", ""},
    {"SimIMU", "模拟惯导", ""},
    {"SimFlow", "模拟光流", ""},
    {"SimRadio", "模拟电台", ""},
    {"SimCar", "模拟小车", ""},
    {"SIM_MODE", "飞行模式", "0 姿态，1 定高，2 定点，3 程控"},
    {"SIM_TURN", "转弯速度", "最大的转弯速度，度/秒"},
    {"SIM_HEIGHT", "高度", "离地高度，厘米"},
    {"SIM_SPEED", "速度", "厘米/秒"},
    {"SIM_BAR_OFFSET", "气压计偏差", "厘米"},
    {"SIM_FLIGHT_TIME", "续航时间", "悬停到电池耗尽的时间，秒"},
    {"SIM_RANGE_OFFSET", "测距仪偏差", "厘米"},
    {"SIM_WIND", "风速", "米/秒"},
    {"SIM_SWAY", "晃动", "阵风是风速的百分之几，或者桌面晃动的角度"},
    {"SIM_WIND_FROM", "风向", "从正北顺时针，度"},
    {"SIM_HOME_LNG", "经度：起飞点所在的位置", "度"},
    {"SIM_HOME_LAT", "纬度：起飞点所在的位置", "度"},
    {"SIM_PICTURES", "图像", "1：发送活动的图像"},
    {"SIM_P_POSITION", "P位置控制器的比例增益系数", "1/秒"},
    {"SIM_P_VELOCITY", "速度P", "1/秒"},
    {"SIM_P_ATTITUDE", "横滚P", "1/秒，俯仰也用它"},
    {"SIM_P_RATE", "角速度P", "1/秒"},
    {"SIM_BORN", "出厂时间", "1970 年起的秒数"},
    {"SIM_NOTE", "备注", "任意文字"},
    {"SIM_SERIAL", "序列号", "不能写入"},
    {"SIM_CHARGE", "电池电量", "剩余电量的百分比：写入后电池立即变为这个电量，飞行时会逐渐减少，直到耗尽"},
    {"SIM_DISTANCE", "距离", "到对方的距离，米"},
    {"SIM_TOP_SPEED", "最高速度", "厘米/秒"},
    {"SIM_ACCELERATION", "加速度", "厘米/秒/秒"},
    {"SIM_DRIVING_TIME", "行驶时间", "到电池耗尽的时间，秒"},
    {"RF_POWER", "发射功率", "dBm"},
    {"RF_CHANNEL", "信道", ""},
    {"IP_PORT", "数据端口", "收发数据的端口"},
    {"TAKE_OFF", "起飞", "高度，厘米；0：按参数"},
    {"LAND", "降落", ""},
    {"TURN", "转弯", "度/秒，悬停时"},
    {"HOVER", "悬停", "原地"},
    {"GO_TO", "飞往", "距起飞点：北、西、上，厘米"},
    {"YAW", "偏航", "从正北向左的角度"},
    {"RETURN_HOME", "返航", "并降落"},
    {"WAYPOINTS", "航点飞行", "从这个航点开始"},
    {"ADD", "求和", "报告各值之和"},
    {"UNLOCK", "解锁", ""},
    {"LOCK", "上锁", "在地面"},
    {"MODE", "模式", "同飞行模式"},
    {"STOP", "停车", ""},
    {"unlocked", "已解锁", ""},
    {"landed", "已降落", ""},
    {"battery low", "电量低", ""},
    {"battery nearly empty: landing", "电量即将耗尽，正在降落", ""},
    {"done", "完成", ""},
    {"new firmware", "新固件", ""},
    {"is the sum", "是总和", ""},
    {"dBm: the link is poor", "dBm：链路质量差", ""},
};

struct Code {
    char32_t character;
    std::uint16_t gbk;
};

// The Chinese characters of the translations, sorted.
constexpr Code codes[]{
    {U'、', 0xA1A2}, {U'上', 0xC9CF}, {U'不', 0xB2BB}, {U'个', 0xB8F6}, {U'为', 0xCEAA}, {U'之', 0xD6AE}, {U'也', 0xD2B2},
    {U'从', 0xB4D3}, {U'仪', 0xD2C7}, {U'仰', 0xD1F6}, {U'件', 0xBCFE}, {U'任', 0xC8CE}, {U'会', 0xBBE1}, {U'位', 0xCEBB},
    {U'低', 0xB5CD}, {U'余', 0xD3E0}, {U'例', 0xC0FD}, {U'信', 0xD0C5}, {U'俯', 0xB8A9}, {U'值', 0xD6B5}, {U'偏', 0xC6AB},
    {U'停', 0xCDA3}, {U'像', 0xCFF1}, {U'光', 0xB9E2}, {U'入', 0xC8EB}, {U'写', 0xD0B4}, {U'减', 0xBCF5}, {U'几', 0xBCB8},
    {U'出', 0xB3F6}, {U'分', 0xB7D6}, {U'列', 0xC1D0}, {U'到', 0xB5BD}, {U'制', 0xD6C6}, {U'剩', 0xCAA3}, {U'功', 0xB9A6},
    {U'加', 0xBCD3}, {U'动', 0xB6AF}, {U'北', 0xB1B1}, {U'即', 0xBCB4}, {U'厂', 0xB3A7}, {U'压', 0xD1B9}, {U'厘', 0xC0E5},
    {U'原', 0xD4AD}, {U'参', 0xB2CE}, {U'发', 0xB7A2}, {U'变', 0xB1E4}, {U'口', 0xBFDA}, {U'台', 0xCCA8}, {U'号', 0xBAC5},
    {U'各', 0xB8F7}, {U'同', 0xCDAC}, {U'后', 0xBAF3}, {U'向', 0xCFF2}, {U'告', 0xB8E6}, {U'和', 0xBACD}, {U'器', 0xC6F7},
    {U'固', 0xB9CC}, {U'图', 0xCDBC}, {U'在', 0xD4DA}, {U'地', 0xB5D8}, {U'增', 0xD4F6}, {U'备', 0xB1B8}, {U'大', 0xB4F3},
    {U'始', 0xCABC}, {U'姿', 0xD7CB}, {U'字', 0xD7D6}, {U'它', 0xCBFC}, {U'完', 0xCDEA}, {U'定', 0xB6A8}, {U'对', 0xB6D4},
    {U'导', 0xB5BC}, {U'射', 0xC9E4}, {U'将', 0xBDAB}, {U'小', 0xD0A1}, {U'少', 0xC9D9}, {U'尽', 0xBEA1}, {U'左', 0xD7F3},
    {U'差', 0xB2EE}, {U'已', 0xD2D1}, {U'年', 0xC4EA}, {U'并', 0xB2A2}, {U'序', 0xD0F2}, {U'度', 0xB6C8}, {U'开', 0xBFAA},
    {U'式', 0xCABD}, {U'弯', 0xCDE4}, {U'往', 0xCDF9}, {U'态', 0xCCAC}, {U'总', 0xD7DC}, {U'悬', 0xD0FC}, {U'惯', 0xB9DF},
    {U'意', 0xD2E2}, {U'成', 0xB3C9}, {U'或', 0xBBF2}, {U'所', 0xCBF9}, {U'报', 0xB1A8}, {U'拟', 0xC4E2}, {U'按', 0xB0B4},
    {U'据', 0xBEDD}, {U'控', 0xBFD8}, {U'收', 0xCAD5}, {U'数', 0xCAFD}, {U'文', 0xCEC4}, {U'新', 0xD0C2}, {U'方', 0xB7BD},
    {U'时', 0xCAB1}, {U'是', 0xCAC7}, {U'晃', 0xBBCE}, {U'最', 0xD7EE}, {U'桌', 0xD7C0}, {U'模', 0xC4A3}, {U'横', 0xBAE1},
    {U'正', 0xD5FD}, {U'比', 0xB1C8}, {U'气', 0xC6F8}, {U'求', 0xC7F3}, {U'池', 0xB3D8}, {U'注', 0xD7A2}, {U'活', 0xBBEE},
    {U'流', 0xC1F7}, {U'测', 0xB2E2}, {U'渐', 0xBDA5}, {U'滚', 0xB9F6}, {U'点', 0xB5E3}, {U'率', 0xC2CA}, {U'用', 0xD3C3},
    {U'电', 0xB5E7}, {U'百', 0xB0D9}, {U'的', 0xB5C4}, {U'益', 0xD2E6}, {U'直', 0xD6B1}, {U'离', 0xC0EB}, {U'秒', 0xC3EB},
    {U'程', 0xB3CC}, {U'立', 0xC1A2}, {U'端', 0xB6CB}, {U'米', 0xC3D7}, {U'系', 0xCFB5}, {U'纬', 0xCEB3}, {U'经', 0xBEAD},
    {U'续', 0xD0F8}, {U'置', 0xD6C3}, {U'者', 0xD5DF}, {U'耗', 0xBAC4}, {U'能', 0xC4DC}, {U'航', 0xBABD}, {U'落', 0xC2E4},
    {U'行', 0xD0D0}, {U'西', 0xCEF7}, {U'角', 0xBDC7}, {U'解', 0xBDE2}, {U'计', 0xBCC6}, {U'质', 0xD6CA}, {U'起', 0xC6F0},
    {U'距', 0xBEE0}, {U'路', 0xC2B7}, {U'车', 0xB3B5}, {U'转', 0xD7AA}, {U'返', 0xB7B5}, {U'这', 0xD5E2}, {U'送', 0xCBCD},
    {U'逐', 0xD6F0}, {U'速', 0xCBD9}, {U'道', 0xB5C0}, {U'量', 0xC1BF}, {U'针', 0xD5EB}, {U'链', 0xC1B4}, {U'锁', 0xCBF8},
    {U'间', 0xBCE4}, {U'阵', 0xD5F3}, {U'降', 0xBDB5}, {U'面', 0xC3E6}, {U'顺', 0xCBB3}, {U'风', 0xB7E7}, {U'飞', 0xB7C9},
    {U'驶', 0xCABB}, {U'高', 0xB8DF}, {U'，', 0xA3AC}, {U'：', 0xA3BA}, {U'；', 0xA3BB},
};
// clang-format on

// Removes the first character of `text` and returns it.
char32_t next_character(std::string_view& text) {
    const auto first = static_cast<std::uint8_t>(text[0]);
    const std::size_t size = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    char32_t character = size == 1 ? first : first & (0x7Fu >> size);
    for (std::size_t i = 1; i < size; ++i) character = character << 6 | (static_cast<std::uint8_t>(text[i]) & 0x3Fu);
    text.remove_prefix(size);
    return character;
}

std::string as_gbk(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const char32_t character = next_character(text);
        if (character < 0x80) {
            out += static_cast<char>(character);
            continue;
        }
        const auto* const code = std::lower_bound(std::begin(codes), std::end(codes), character,
                                                  [](const Code& one, char32_t c) { return one.character < c; });
        if (code == std::end(codes) || code->character != character) continue;
        out += static_cast<char>(code->gbk >> 8);
        out += static_cast<char>(code->gbk & 0xFF);
    }
    return out;
}

const Translation* translation_of(std::string_view english) {
    const auto* const row = std::find_if(std::begin(translations), std::end(translations),
                                         [&](const Translation& one) { return one.english == english; });
    return row == std::end(translations) ? nullptr : row;
}

std::string_view text_in(const Reading& reading, std::string_view name) {
    const Field* const field = reading.field(name);
    return field != nullptr && field->type == Type::text ? std::get<std::string_view>(reading.value(*field)) : std::string_view{};
}

constexpr std::size_t max_info = 50;    // bytes, as the vendor's library cuts it

}    // namespace

FrameView ChineseTexts::of(FrameView frame) {
    if (form_ == TextForm::en) return frame;
    const Reading reading = read(frame);
    if (!reading) return frame;
    const std::string_view name = text_in(reading, "name");
    const Translation* const found = translation_of(name.empty() ? text_in(reading, "str") : name);
    if (found == nullptr) return frame;
    std::vector<std::uint8_t> data;
    for (const Field& field : reading.fields()) {
        const Bytes before = reading.bytes_of(field);
        if (field.type != Type::text) {
            data.insert(data.end(), before.begin(), before.end());
            continue;
        }
        const std::string_view chinese = field.name == "info" ? found->info : found->chinese;
        std::string text = form_ == TextForm::gbk ? as_gbk(chinese) : std::string{chinese};
        if (field.is_open()) text.resize(std::min(text.size(), max_info));
        else text.resize(field.size());
        data.insert(data.end(), text.begin(), text.end());
    }
    bytes_.resize(overhead + data.size());
    encode(bytes_, frame.source(), frame.destination(), frame.id(), data);
    return FrameView{bytes_};
}

}    // namespace ano::world
