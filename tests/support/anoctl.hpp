// Runs anoctl within the test.
#pragma once
#include <anoctl/anoctl.hpp>

#include <sys/mman.h>
#include <unistd.h>

#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace support {

struct AnoctlResult {
    int exit;
    std::string out;
    std::string err;
};

/// `input`: the content of standard input.
inline AnoctlResult anoctl(std::vector<std::string> words, const std::string& input = {}, bool terminal = false,
                           bool color = false) {
    std::vector<const char*> argv{"anoctl"};
    for (const std::string& word : words) argv.push_back(word.c_str());
    const int in = memfd_create("input", MFD_CLOEXEC);
    if (in < 0 || write(in, input.data(), input.size()) != static_cast<ssize_t>(input.size())) throw std::runtime_error("memfd");
    lseek(in, 0, SEEK_SET);
    std::ostringstream out;
    std::ostringstream err;
    anoctl::Streams streams{in, out, err, terminal, color};
    const int code = anoctl::run(static_cast<int>(argv.size()), argv.data(), streams);
    close(in);
    return {code, out.str(), err.str()};
}

}    // namespace support
