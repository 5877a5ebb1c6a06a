// Prints a frame as one line: for people on a terminal, for awk in a pipe, or as JSON.
#pragma once
#include "anoctl.hpp"
#include "frame_taker.hpp"

#include <ano/flexible.hpp>
#include <ano_json/frame_json.hpp>

#include <memory>
#include <optional>
#include <string>

namespace anoctl {

/// The options of every subcommand that shows or makes frames.
struct FrameOptions {
    bool json = false;
    std::optional<ano::Encoding> encoding;          // std::nullopt: automatic
    std::optional<ano::ValueType7> value_type_7;    // std::nullopt: f32
    std::string config;                             // the file with the layouts of flexible messages

    /// `self` must live as long as the run.
    static void add(Options& options, FrameOptions& self);
    /// --encoding alone.
    static void add_encoding(Options& options, FrameOptions& self);
    /// Throws UsageError when `config` can't be read.
    ano::FlexibleLayouts layouts() const;
    /// For reading and writing frames; `layouts` must live as long as the result.
    ano::JsonOptions json_options(const ano::FlexibleLayouts& layouts) const {
        return {&layouts, encoding.value_or(ano::Encoding::automatic), value_type_7.value_or(ano::ValueType7::f32)};
    }
};

class FramePrinter {
public:
    FramePrinter(Streams& streams, const FrameOptions& options);
    FramePrinter(const FramePrinter&) = delete;
    FramePrinter& operator=(const FramePrinter&) = delete;

    /// One line.
    void print(ano::FrameView frame, const Passage& passage = {});
    const ano::FlexibleLayouts& layouts() const noexcept { return layouts_; }

private:
    void print(const Passage& passage);
    void plain(ano::FrameView frame, const ano::Json& json);
    void columns(ano::FrameView frame, const ano::Json& json);
    std::string colored(const char* color, const std::string& text) const;

    Streams& streams_;
    bool json_;
    ano::FlexibleLayouts layouts_;
    ano::JsonOptions options_;
};

/// "14:03:07.123", local time; `time` in seconds since 1970.
std::string clock_text(double time);

/// What is wrong with DATA of a frame, as a clause; empty when it is correct, or the message is unknown.
std::string malformation(ano::FrameView frame, const ano::FlexibleLayouts& layouts);

}    // namespace anoctl
