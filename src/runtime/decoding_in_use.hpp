// The decoding of frames: the layouts of flexible messages, and the links with attitude=lx.
#pragma once
#include <ano/flexible.hpp>
#include <gateway/settings.hpp>
#include <record/decoding.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace anogate {

/// The layouts are those of the configuration, or those that a client has set until the configuration changes them.
class DecodingInUse {
public:
    using Layouts = std::vector<ano::FlexibleSpec>;

    /// `settings` outlives it. `on_overruled` is called when layouts of a client are dropped because the configuration has changed.
    DecodingInUse(const Settings& settings, std::function<void()> on_overruled)
        : settings_{settings}, on_overruled_{std::move(on_overruled)} {}

    /// Never nullptr; another object after a change.
    const DecodingPtr& decoding() const noexcept { return decoding_; }
    /// The number of changes of decoding().
    std::uint64_t changes() const noexcept { return changes_; }
    /// The layouts of a client, else those of the configuration. decoding() also has the layouts of replayed recordings for ids
    /// that have none here.
    const Layouts& layouts() const noexcept { return of_client_ ? *of_client_ : settings_.flexible; }
    bool is_of_client() const noexcept { return of_client_.has_value(); }

    /// A client sets the layouts.
    void set(Layouts layouts);
    /// The configuration has changed; `before` are its former layouts. If they differ, those of a client are set aside.
    void settings_changed(const Layouts& before, std::vector<DecodingPtr> replayed);
    /// The configuration is confirmed: drops the layouts that were set aside.
    void settle();
    /// The former configuration is restored: uses the layouts that were set aside again, if they belong to it.
    void restore();
    /// The decodings of recordings that are being replayed.
    void set_replayed(std::vector<DecodingPtr> replayed);

private:
    struct SetAside {
        Layouts of_client, of_file;
    };
    void renew();

    const Settings& settings_;
    std::function<void()> on_overruled_;
    std::optional<Layouts> of_client_;
    std::optional<SetAside> set_aside_;    // layouts of a client, and the configured ones at that time
    std::vector<DecodingPtr> replayed_;
    DecodingPtr decoding_ = decoding_of(settings_, settings_.flexible);
    std::uint64_t changes_ = 0;
};

}    // namespace anogate
