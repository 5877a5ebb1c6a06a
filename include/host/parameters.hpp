// Reads the parameters of a device and their values (0xE0 to 0xE3; protocol text, section 4).
//
// Flow:    Parameters parameters{device, &cache};
//          parameters.read_all(now);                     // then drive the device until parameters.end()
//          for (const ParameterInfo& p : parameters.descriptions()) use(p.name, parameters.value(p.id));
#pragma once
#include <host/description_cache.hpp>
#include <host/gather.hpp>
#include <host/parameter_info.hpp>
#include <host/value.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ano::host {

/// Reads device info, the number of parameters, every description that is not cached, and values. At the end it reads the number
/// again: if the device has changed, everything is read once more.
///
/// If the device is known and not all values are wanted, device info and number are asked just before the values, without waiting
/// for the answers: one round trip. The ids are below the number that the device last reported, and it was not away since.
///
/// If only an earlier run knew the device (DescriptionCache::recall()), or it may have restarted or be another one since
/// (Device::doubts()), the descriptions of the wanted values are read with them and compared. If one differs, or fewer are found
/// than wanted, everything is read. If all values are wanted, all descriptions are read with them.
class Parameters final : public Gather {
public:
    enum class Values : std::uint8_t { all, none, named };

    /// `cache` may be nullptr, and must outlive this object.
    explicit Parameters(Device& device, DescriptionCache* cache = nullptr) : Gather{device}, cache_{cache} {}

    void read(Values values, TimePoint now);
    void read_all(TimePoint now) { read(Values::all, now); }
    /// Reads only the values of these; names that no parameter or several parameters have are left out.
    void read_named(std::vector<std::string> names, TimePoint now) {
        names_ = std::move(names);
        read(Values::named, now);
    }

    /// Reads the values of the parameters with these names or, if no parameter has such a name, these numbers.
    void read_called(std::vector<std::string> words, TimePoint now) {
        may_be_numbers_ = true;
        read_named(std::move(words), now);
    }

    /// To be called before reading values of some parameters: their descriptions are always compared, since one of them will be
    /// written.
    void compare_anyway() noexcept { compares_anyway_ = true; }

    /// Reads only the values for which `wanted` is true, of `at_least` parameters. It is called when the descriptions are known.
    void read_where(std::function<bool(const ParameterInfo&)> wanted, TimePoint now, std::size_t at_least = 0) {
        is_wanted_ = std::move(wanted);
        at_least_ = at_least;
        read(Values::named, now);
    }

    /// Reads only these values, by id; ids that do not exist are left out.
    void read_numbered(std::vector<std::uint16_t> ids, TimePoint now) {
        wanted_ = std::move(ids);
        read(Values::named, now);
    }

    /// To be called before reading values: the ids that are read if the device is asked by number (Device::ask_by_number()). Each is
    /// then an i32 whose name is its id; those that the device does not have get no type.
    void accept_unlisted(std::vector<std::uint16_t> ids) { unlisted_ = std::move(ids); }

    /// By id, from 0 without gaps; complete when the task is done. Descriptions that were not received have no name and no type.
    const std::vector<ParameterInfo>& descriptions() const noexcept { return descriptions_; }
    /// The bytes of the value as received; empty: not received.
    Bytes bytes(std::uint16_t id) const noexcept { return id < values_.size() ? Bytes{values_[id]} : Bytes{}; }
    /// std::nullopt if it was not received, is shorter than its type, or its type is not known.
    std::optional<AnyValue> value(std::uint16_t id) const;
    /// The parameter with this name.
    Found find(std::string_view name) const noexcept { return find_parameter(descriptions_, name); }
    /// Device::doubts() when reading began: the data may be wrong if there are later doubts.
    std::uint32_t doubts() const noexcept { return doubts_; }
    /// Whether the descriptions come from the cache.
    bool from_cache() const noexcept { return from_cache_; }

private:
    enum Step : std::uint32_t { ask_info = first_step, ask_count, ask_count_again };

    Request question(std::uint32_t i) override;
    bool took(std::uint32_t i, FrameView answer) override;
    void gathered(TimePoint now) override;
    Request probe() override { return question::parameter_count(0); }
    void step_ended(const Ended& ended, TimePoint now) override;
    Fault subject() const override { return {"parameters"}; }

    void start(TimePoint now);
    void counted(TimePoint now);
    void counted_again(TimePoint now);
    void start_known(const std::vector<ParameterInfo>& known, TimePoint now);
    bool is_certain(TimePoint now) const;
    bool has_changed() const;
    std::optional<std::uint16_t> first_lacking() const;
    void settle_layout();
    bool accept_description(std::uint16_t id, FrameView answer);
    bool compared(std::uint16_t id, FrameView answer);
    bool recall();
    void read_again(TimePoint now);
    bool is_unlisted() const noexcept { return device().is_asked_by_number() && !unlisted_.empty(); }
    void ask_unlisted(TimePoint now);
    bool accept_value(std::uint16_t id, FrameView answer);
    void ask_named(TimePoint now);

    // If all values are wanted, descriptions and values are read alternately, so that the first parameters are complete early.
    enum class Asks : std::uint8_t { descriptions, values, both, named_values, named_both };
    // checks_ is even.
    bool is_description(std::uint32_t i) const noexcept {
        return asks_ == Asks::descriptions || ((asks_ == Asks::both || asks_ == Asks::named_both) && i % 2 == 0);
    }
    std::uint16_t id_of_question(std::uint32_t i) const noexcept {
        if (asks_ == Asks::named_values) return named_[i - checks_];
        if (asks_ == Asks::named_both) return named_[(i - checks_) / 2];
        return static_cast<std::uint16_t>(asks_ == Asks::both ? i / 2 : i);
    }

    DescriptionCache* cache_;
    Values values_wanted_ = Values::all;
    std::optional<std::uint16_t> count_;
    std::uint32_t presence_ = 0;
    std::uint32_t doubts_ = 0, signs_ = 0;
    Asks asks_ = Asks::both;
    std::uint32_t checks_ = 0;    // number of leading questions that check whether the device is the same: 2, or 0
    std::vector<std::string> names_;
    bool may_be_numbers_ = false;    // names_ that no parameter has are numbers
    std::function<bool(const ParameterInfo&)> is_wanted_;
    std::size_t at_least_ = 0;             // the minimum number of parameters that is_wanted_ selects
    std::vector<std::uint16_t> wanted_;    // by id
    std::vector<std::uint16_t> named_;     // the ids of names_ and wanted_
    std::vector<std::uint16_t> unlisted_;
    bool from_cache_ = false;
    bool compares_anyway_ = false;
    bool compares_ = false;    // they are from an earlier run, or the device may be another one since
    bool differs_ = false;     // one of them has changed
    bool started_again_ = false;
    std::vector<ParameterInfo> descriptions_;
    std::vector<std::vector<std::uint8_t>> frames_;    // the descriptions as received, until all are complete
    LayoutVotes votes_;
    std::vector<std::vector<std::uint8_t>> values_;
};

}    // namespace ano::host
