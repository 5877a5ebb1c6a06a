// Whether a frame is a command of a ground station, which gets one of the places that a listening link reserves.
#pragma once
#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/frame.hpp>

namespace anogate {

inline bool is_command_of_host(ano::FrameView frame) noexcept {
    return ano::address::is_host(frame.source()) && ano::intent_of(frame) == ano::Intent::acts;
}

}    // namespace anogate
