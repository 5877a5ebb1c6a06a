// A GPIO chip of the kernel's simulator, and the other side of its lines: the level of an output, and the level applied to an
// input.
#pragma once
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include <unistd.h>

namespace support {

class GpioSim {
public:
    /// `names` of lines; `hogs`: lines used by the kernel, with the name of the user.
    GpioSim(std::string name, int lines, const std::map<int, std::string>& names = {},
            const std::map<int, std::string>& hogs = {})
        : folder_{"/sys/kernel/config/gpio-sim/" + std::move(name)} {
        std::filesystem::create_directories(bank());
        write(bank() + "/num_lines", std::to_string(lines));
        write(bank() + "/label", label());
        for (const auto& [line, text] : names) write(folder(line) + "/name", text);
        for (const auto& [line, text] : hogs) {
            std::filesystem::create_directories(folder(line) + "/hog");
            write(folder(line) + "/hog/name", text);
            write(folder(line) + "/hog/direction", "output-low");
        }
        plug();
    }
    ~GpioSim() {
        unplug();
        for (const auto& entry : std::filesystem::directory_iterator{bank()}) {
            if (!entry.is_directory()) continue;
            std::error_code none;
            std::filesystem::remove(entry.path() / "hog", none);
            ::rmdir(entry.path().c_str());
        }
        ::rmdir(bank().c_str());
        ::rmdir(folder_.c_str());
    }
    GpioSim(const GpioSim&) = delete;
    GpioSim& operator=(const GpioSim&) = delete;

    void plug() {
        write(folder_ + "/live", "1");
        chip_ = read(bank() + "/chip_name");
        device_ = "/sys/devices/platform/" + read(folder_ + "/dev_name") + "/" + chip_;
    }
    void unplug() { std::ofstream{folder_ + "/live"} << "0"; }

    const std::string& chip() const { return chip_; }    // "gpiochip0"
    std::string label() const { return "sim-" + std::filesystem::path{folder_}.filename().string(); }
    /// The physical level, before active_low is applied.
    bool level(int line) const { return read(at(line) + "/value") == "1"; }
    void pull(int line, bool up) const { write(at(line) + "/pull", up ? "pull-up" : "pull-down"); }
    bool pulled_up(int line) const { return read(at(line) + "/pull") == "pull-up"; }
    std::string pull_file(int line) const { return at(line) + "/pull"; }

private:
    std::string bank() const { return folder_ + "/bank"; }
    std::string at(int line) const { return device_ + "/sim_gpio" + std::to_string(line); }
    std::string folder(int line) const {
        const std::string path = bank() + "/line" + std::to_string(line);
        std::filesystem::create_directories(path);
        return path;
    }
    static std::string read(const std::string& path) {
        std::string text;
        std::ifstream{path} >> text;
        return text;
    }
    static void write(const std::string& path, const std::string& text) {
        std::ofstream file{path};
        if (!(file << text << std::flush)) throw std::runtime_error("can't write " + text + " to " + path);
    }

    std::string folder_;
    std::string chip_;
    std::string device_;
};

}    // namespace support
