// Runs a fuzz target on files, and on every file of folders, without a fuzzer: the target detects failures.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
    namespace fs = std::filesystem;
    std::vector<fs::path> files;
    for (int i = 1; i < argc; ++i) {
        if (fs::is_directory(argv[i]))
            for (const auto& entry : fs::directory_iterator{argv[i]}) files.push_back(entry.path());
        else files.emplace_back(argv[i]);
    }
    std::sort(files.begin(), files.end());
    for (const auto& path : files) {
        std::ifstream file{path, std::ios::binary};
        if (!file) {
            std::fprintf(stderr, "%s: cannot be read\n", path.c_str());
            return 1;
        }
        std::fprintf(stderr, "%s\n", path.c_str());    // the last printed name is the file that failed
        const std::vector<char> text{std::istreambuf_iterator<char>{file}, {}};
        const std::vector<std::uint8_t> bytes{text.begin(), text.end()};    // exactly its size
        LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
    if (files.empty()) std::fprintf(stderr, "no file to replay\n");
    return files.empty() ? 1 : 0;
}
