#include <config/config.hpp>
#include <runtime/decoding_in_use.hpp>

#include <algorithm>
#include <iterator>
#include <utility>

namespace anogate {

void DecodingInUse::set(Layouts layouts) {
    of_client_.reset();
    if (layouts != settings_.flexible) of_client_ = std::move(layouts);
    renew();
}

void DecodingInUse::settings_changed(const Layouts& before, std::vector<DecodingPtr> replayed) {
    if (of_client_ && before != settings_.flexible) {
        if (!set_aside_ || set_aside_->of_file != settings_.flexible) set_aside_ = {*std::move(of_client_), before};
        of_client_.reset();
    }
    set_replayed(std::move(replayed));
}

void DecodingInUse::settle() {
    if (std::exchange(set_aside_, std::nullopt)) on_overruled_();
}

void DecodingInUse::restore() {
    if (!set_aside_ || set_aside_->of_file != settings_.flexible) return settle();
    of_client_ = std::exchange(set_aside_, std::nullopt)->of_client;
    renew();
}

void DecodingInUse::set_replayed(std::vector<DecodingPtr> replayed) {
    replayed_ = std::move(replayed);
    renew();
}

void DecodingInUse::renew() {
    Layouts all = layouts();
    for (const DecodingPtr& played : replayed_) {
        const auto is_new = [&](const ano::FlexibleSpec& one) {
            return std::ranges::none_of(all, [&](const ano::FlexibleSpec& other) { return other.id == one.id; });
        };
        Layouts added;
        std::ranges::copy_if(played->flexible(), std::back_inserter(added), is_new);
        all.insert(all.end(), added.begin(), added.end());
    }
    DecodingPtr now = decoding_of(settings_, std::move(all));
    if (*now == *decoding_) return;
    decoding_ = std::move(now);
    ++changes_;
}

}    // namespace anogate
