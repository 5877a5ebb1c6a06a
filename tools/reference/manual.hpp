// The manual pages.
#pragma once
#include <string>

namespace reference {

std::string anogated_page();         // anogated(8)
std::string anoctl_page();           // anoctl(1)
std::string configuration_page();    // anogate.json(5)

}    // namespace reference
