// anoctl image DIR: saves pictures of devices (0xB0) as files.
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "file_text.hpp"
#include "frames_of.hpp"
#include "pictures.hpp"
#include "png.hpp"
#include "refused_lengths.hpp"

#include <ano/hex.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <utility>

namespace anoctl {
namespace {

namespace fs = std::filesystem;

/// The files of a folder: DIR/0xDF-0001.png and so on; numbering continues after existing files.
class PictureFolder {
public:
    explicit PictureFolder(fs::path folder) : folder_{std::move(folder)} {
        std::error_code error;
        fs::create_directories(folder_, error);
        if (error) throw Failure{folder_.string() + ": cannot create: " + error.message()};
    }

    /// Writes a file and returns its name. The file appears only when it is complete.
    std::string write(const Picture& picture) {
        const std::string bytes = png_of(picture);
        std::string path;
        do path = numbered(picture.source, ++number_[picture.source]);
        while (fs::exists(path + whole) || fs::exists(path + part));
        path += picture.is_whole() ? whole : part;
        write_file(path, bytes);
        return path;
    }

private:
    static constexpr const char *whole = ".png", *part = "-part.png";    // a number is used for only one of them

    std::string numbered(std::uint8_t source, unsigned number) const {
        std::array<char, 32> digits{};
        std::snprintf(digits.data(), digits.size(), "-%04u", number);
        return (folder_ / (ano::hex_byte(source) + digits.data())).string();
    }

    fs::path folder_;
    std::map<std::uint8_t, unsigned> number_;
};

class PictureWriter final : public FrameReceiver {
public:
    /// `refused`: nullptr without a gateway; then the link prints the hint.
    PictureWriter(const std::string& folder, bool json, std::uint64_t count, RefusedLengths* refused, Streams& streams)
        : folder_{folder}, json_{json}, left_{count}, refused_{refused}, streams_{streams} {}

    bool accept(ano::FrameView frame, const Passage& passage) override {
        Pictures::Taken taken = pictures_.accept(frame, ano::Clock::now(), passage.time);
        if (!taken.fault.empty() && taken.fault != std::exchange(fault_, taken.fault))
            streams_.err << "anoctl: an image frame of " << ano::hex_byte(frame.source()) << ": " << taken.fault << std::endl;
        for (const Picture& picture : taken.ended) {
            const bool is_joined = picture.is_first && !picture.is_whole();
            write(picture, is_joined);
            if (!is_joined && left_ > 0 && --left_ == 0) {
                done_ = true;
                return false;
            }
        }
        return true;
    }
    bool flush() override {
        if (refused_ && ano::Clock::now() >= look_at_) print_refused();
        return bool{streams_.out.flush()};
    }
    void miss(std::uint64_t count, const std::string&, std::string_view) override {
        print_note(streams_, plural(count, "frame") + " lost: the buffer of the gateway was full");
    }
    /// To be called after the last frame.
    void end() {
        if (refused_) print_refused();
        if (!done_)
            for (const Picture& picture : pictures_.end()) write(picture, false);
        std::string words = plural(written_, "picture");
        if (partial_ > 0) words += ", " + std::to_string(partial_) + " of them incomplete";
        if (joined_ > 0) words += "; and the end of " + plural(joined_, "picture") + " that probably started earlier";
        print_note(streams_, words);
    }

private:
    void print_refused() {
        look_at_ = ano::Clock::now() + look_every;
        for (const std::string& sentence : refused_->look()) print_note(streams_, sentence);
    }
    /// `is_joined`: reception probably began in the middle of this picture, the first one of its sender. It is not counted.
    void write(const Picture& picture, bool is_joined) {
        const std::string file = folder_.write(picture);
        if (is_joined) ++joined_;
        else ++written_;
        if (!is_joined && !picture.is_whole()) ++partial_;
        if (json_) return print_json(picture, file);
        streams_.out << file << ": " << ano::hex_byte(picture.source) << ' ' << picture.width << 'x' << picture.height << ' '
                     << color_name(picture.color);
        if (!picture.is_whole()) streams_.out << ", " << picture.rows() << " of " << picture.height << " rows received";
        streams_.out << '\n';
    }
    void print_json(const Picture& picture, const std::string& file) {
        streams_.out << ano::json_text(nlohmann::ordered_json{{"file", file},
                                                              {"from", picture.source},
                                                              {"time", picture.began},
                                                              {"flag", picture.flag},
                                                              {"color", color_name(picture.color)},
                                                              {"width", picture.width},
                                                              {"height", picture.height},
                                                              {"rows", picture.rows()},
                                                              {"whole", picture.is_whole()},
                                                              {"val", ano::hex(picture.value)}})
                     << '\n';
    }

    PictureFolder folder_;
    const bool json_;
    std::uint64_t left_;    // 0: no limit
    static constexpr std::chrono::seconds look_every{3};
    RefusedLengths* refused_;
    ano::TimePoint look_at_ = ano::Clock::now() + look_every;
    Streams& streams_;
    Pictures pictures_;
    std::string fault_;    // last printed
    std::uint64_t written_ = 0, partial_ = 0, joined_ = 0;
    bool done_ = false;
};

struct Image {
    FramesOf from;
    std::string folder;
    std::uint64_t count = 0;
    bool json = false;

    int run(Streams& streams) const {
        std::optional<RefusedLengths> refused;
        if (from.link.empty()) refused.emplace(from.gateway);
        PictureWriter writer{folder, json, count, refused ? &*refused : nullptr, streams};
        const std::string why = from.each({"image"}, writer, streams, "image");
        writer.end();
        if (!why.empty()) throw Failure{why};
        return fine;
    }
};

}    // namespace

Run add_image(Options& options) {
    const auto self = std::make_shared<Image>();
    const auto read_count = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        const auto* count = number ? std::get_if<std::uint64_t>(&*number) : nullptr;
        if (count == nullptr || *count == 0) return ano::in_quotes(word) + " is not a number of pictures (1 or more)";
        self->count = *count;
        return {};
    };
    options.push_back({"folder", &self->folder, "DIR",
                       "Output folder: 0xDF-0001.png, continuing after existing files; incomplete pictures are named -part.png "
                       "and contain the received rows (an incomplete first picture is not counted)",
                       true});
    options.push_back({"--count", Option::Read{read_count}, "N", "Exit after N pictures"});
    FramesOf::add(options, self->from);
    options.push_back({"--json", &self->json, "", "Print one JSON object per picture"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
