#include <ano/hex.hpp>
#include <devices/calibration_work.hpp>
#include <devices/notes.hpp>

#include <utility>

namespace anogate {

const std::string* Notes::find(const std::string& name) const {
    const auto found = all_->find(name);
    return found != all_->end() ? &found->second : nullptr;
}

std::vector<std::string> Notes::names(std::uint8_t address) const {
    const std::string of_it = "-" + ano::hex_byte(address);
    std::vector<std::string> names;
    for (const auto& [name, text] : *all_)
        if (const auto at = name.find(of_it);
            at != name.npos && (name[at + of_it.size()] == '-' || name[at + of_it.size()] == '.'))
            names.push_back(name);
    return names;
}

void Notes::keep(const std::string& name, const std::string& text, std::function<void(std::string fault)> done) {
    net_.keep(name, text, [all = all_, name, text, done = std::move(done)](std::string fault) {
        if (fault.empty()) (*all)[name] = text;
        done(std::move(fault));
    });
}

void Notes::forget(const std::string& name) {
    all_->erase(name);
    net_.keep(name, {}, [](const std::string&) {});
}

std::string loader_note(std::uint8_t address) { return "firmware-" + ano::hex_byte(address) + ".json"; }

bool is_note(std::string_view name) {
    const auto address = address_of_note(name);
    const auto sensor = sensor_of_note(name);
    return address && name == (sensor ? keep_name(*address, *sensor) : loader_note(*address));
}

bool is_whole_note(std::string_view name, const std::string& text) {
    const auto sensor = sensor_of_note(name);
    return !sensor || is_whole_backup(text, *sensor);
}

}    // namespace anogate
