#include "run_program.hpp"
#include <anoctl/anoctl.hpp>

#include <sys/errors.hpp>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

namespace anoctl {

std::optional<int> run_program(std::vector<std::string> words) {
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t pid = -1;
    int status = 0;
    const int error = ::posix_spawnp(&pid, arguments[0], nullptr, nullptr, arguments.data(), environ);
    if (error == ENOENT) return std::nullopt;
    if (error != 0) throw Failure{anogate::error_text(words[0], error)};
    while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {}
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}    // namespace anoctl
