// Prints a frame as one line: for people on a terminal, as plain text for awk in a pipe, or as JSON.
#pragma once
#include <anoctl/anoctl.hpp>
#include <anoctl/frame_receiver.hpp>

#include <ano/flexible.hpp>
#include <ano/reading.hpp>
#include <ano/v7.hpp>
#include <ano_json/frame_json.hpp>
#include <record/sender_encodings.hpp>

#include <array>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anoctl {

/// The options of all subcommands that print or create frames.
struct FrameOptions {
    bool json = false;
    std::optional<ano::Encoding> encoding;          // std::nullopt: automatic
    std::optional<ano::ValueType7> value_type_7;    // std::nullopt: f32
    std::string config;                             // file with the layouts of flexible messages
    std::vector<ano::FlexibleSpec> known{};         // layouts if no file is given

    /// `self` must live as long as the run.
    static void add(Options& options, FrameOptions& self);
    /// Only --encoding.
    static void add_encoding(Options& options, FrameOptions& self);
    /// The text of `config`. Throws UsageError if the file is not readable.
    std::string config_text() const;
    /// Throws UsageError if `config` can't be read.
    std::vector<ano::FlexibleSpec> specs() const;
    ano::FlexibleLayouts layouts() const { return ano::FlexibleLayouts{specs()}; }
    /// For decoding and encoding; `layouts` must live as long as the result.
    ano::JsonOptions json_options(const ano::FlexibleLayouts& layouts) const {
        return {&layouts, encoding.value_or(ano::Encoding::automatic), value_type_7.value_or(ano::ValueType7::f32)};
    }
};

class FramePrinter {
public:
    FramePrinter(Streams& streams, const FrameOptions& options);
    FramePrinter(const FramePrinter&) = delete;
    FramePrinter& operator=(const FramePrinter&) = delete;

    /// Prints one line.
    void print(ano::FrameView frame, const Passage& passage = {});
    void print(ano::v7::FrameView frame, const Passage& passage = {});
    /// The following frames are decoded with `decoding`, except for values given by the options.
    void use(const anogate::DecodingPtr& decoding);
    const ano::FlexibleLayouts& layouts() const noexcept { return *options_.flexible; }

private:
    void print(const Passage& passage, std::ostream& out) const;
    void plain(const ano::Reading& reading, const ano::Json& json, bool passes);
    void columns(const ano::Reading& reading, const ano::Json& json, std::ostream& out) const;
    std::string colored(const char* color, const std::string& text) const;

    Streams& streams_;
    bool json_;
    ano::FlexibleLayouts layouts_;    // from the options
    ano::JsonOptions options_;
    bool finds_encoding_;    // no encoding was given
    bool finds_layouts_;     // no layouts were given
    anogate::DecodingPtr decoding_;
    anogate::SenderEncodings encodings_;
};

/// "14:03:07.123", local time; `time` in seconds since 1970.
std::string clock_text(double time);

/// The reason why DATA of a frame has no fields, as a clause. Empty if it has fields, or if the message is unknown or flexible.
std::string undecoded(const ano::Reading& reading);

}    // namespace anoctl
