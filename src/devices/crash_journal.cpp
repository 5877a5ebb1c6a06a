#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <devices/crash_journal.hpp>
#include <devices/device_json.hpp>
#include <devices/unit_note.hpp>
#include <devices/works/calibration_work.hpp>
#include <devices/works/work.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

bool is_about(const std::string& name, std::uint8_t address) {
    const std::string of_it = "-" + ano::hex_byte(address);
    const auto at = name.find(of_it);
    return at != name.npos && (name[at + of_it.size()] == '-' || name[at + of_it.size()] == '.');
}

}    // namespace

const std::string* CrashJournal::find(const std::string& name) const {
    const auto found = all_->find(name);
    return found != all_->end() ? &found->second : nullptr;
}

std::vector<std::string> CrashJournal::names(std::uint8_t address) const {
    std::vector<std::string> names;
    for (const auto& [name, text] : *all_)
        if (is_about(name, address)) names.push_back(name);
    return names;
}

void CrashJournal::keep(const std::string& name, const std::string& text, std::function<void(std::string fault)> done) {
    dropped_.erase(name);
    const std::uint64_t change = ++(*changes_)[name];
    net_.keep(name, text, [all = all_, changes = changes_, change, name, text, done = std::move(done)](std::string fault) {
        if (fault.empty() && (*changes)[name] == change)
            (*all)[name] = text;    // otherwise it was changed or forgotten
                                    // meanwhile
        done(std::move(fault));
    });
}

void CrashJournal::forget(const std::string& name) {
    all_->erase(name);
    ++(*changes_)[name];
    net_.keep(name, {}, [](const std::string&) {});
}

void CrashJournal::drop(const std::string& name, const std::string& why) {
    forget(name);
    dropped_[name] = why;
}

std::vector<std::string> CrashJournal::dropped(std::uint8_t address) const {
    std::vector<std::string> all;
    for (const auto& [name, why] : dropped_)
        if (is_about(name, address)) all.push_back(name + " (" + why + ")");
    return all;
}

bool is_loader_note(std::string_view name) { return is_unit_note_name(name, "firmware"); }

void keep_loader_note(const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info) {
    place.journal.keep(unit_note_name("firmware", place, info), ano::compact_json(unit_json(place, info)) + "\n",
                       [](const std::string&) {});
}

std::optional<ano::host::DeviceInfo> kept_identity(const WorkPlace& place) {
    const std::string name = find_note(place, is_loader_note, WithoutInfo::fits);
    return name.empty() ? std::nullopt : info_in_note(*place.journal.find(name));
}

void forget_loader_notes(CrashJournal& journal, std::uint8_t address, const UnitPlace& here) {
    for (const std::string& name : journal.names(address))
        if (is_loader_note(name) && misfit_of_place(*journal.find(name), here, true).empty()) journal.forget(name);
}

bool is_type_7_note(std::string_view name) { return is_unit_note_name(name, "type7"); }

void keep_type_7(const WorkPlace& place, ano::ValueType7 seven) {
    Json note = unit_json(place, place.device.info());
    note["type7"] = to_string(seven);
    const std::string name = unit_note_name("type7", place, place.device.info()), text = ano::compact_json(note) + "\n";
    place.journal.remember(name, text);    // usable before it is on disk
    place.journal.keep(name, text, [](const std::string&) {});
}

std::optional<ano::ValueType7> kept_type_7(const WorkPlace& place) {
    const std::string name = find_note(place, is_type_7_note);
    return name.empty() ? std::nullopt : value_type_7_in(note_json(*place.journal.find(name)).value("type7", Json{}));
}

bool is_note(std::string_view name) { return sensor_of_note(name) || is_loader_note(name) || is_type_7_note(name); }

std::string loss_of_note(std::string_view name) {
    const auto address = address_of_note(name);
    const std::string who = "the device " + (address ? ano::hex_byte(*address) : std::string{});
    if (is_loader_note(name))
        return who +
               " may be in its boot loader, because an upgrade was in progress; if it does not start, flash it again (with "
               "--force "
               "if it does not report its type), then remove the file";
    if (is_type_7_note(name))
        return "the meaning of value type 7 for " + who + " is lost; state it again (--type7), then remove the file";
    return "the old values of a calibration are not written back; calibrate again, or remove it";
}

std::string damage_of_note(std::string_view name, const std::string& text) {
    const auto sensor = sensor_of_note(name);
    if (sensor && !is_whole_backup(text, *sensor)) return "is damaged: " + loss_of_note(name);
    if (is_loader_note(name) && !names_its_device(name, text)) return "is damaged and ignored: " + loss_of_note(name);
    if (is_type_7_note(name) && (!names_its_device(name, text) || !value_type_7_in(note_json(text).value("type7", Json{}))))
        return "is damaged and ignored: " + loss_of_note(name);
    return {};
}

}    // namespace anogate
