#include "sign_in.hpp"
#include <anoctl/anoctl.hpp>
#include <anoctl/text/gateway_json.hpp>
#include "browser.hpp"

#include <nlohmann/json.hpp>

#include <chrono>
#include <thread>

namespace anoctl {

using ano::Json;

Json SignIn::code(Form form) const {
    const Json wanted{{"form", form == Form::link ? "link" : "digits"}, {"access", view ? "view" : "control"}};
    return parse_answer(gateway.post("/login/code", wanted.dump()));
}

// A browser does not send the part after '#', so the code is in no log.
std::string SignIn::link(const std::string& page) const { return page + "#once=" + text_at(code(Form::link), "code"); }

void SignIn::open(const std::string& page) const {
    const std::string url = link(page);
    const auto yourself = [&](const std::string& why) { return Failure{why + "; open it yourself: " + url}; };
    try {
        const RedirectFile file{url};
        open_in_browser(file.url());
        const auto end = std::chrono::steady_clock::now() + std::chrono::minutes{1};
        while (std::chrono::steady_clock::now() < end) {
            if (text_at(at(at(parse_answer(gateway.ask("GET", "/status")), "http"), "codes"), "link") != "valid") return;
            std::this_thread::sleep_for(std::chrono::milliseconds{200});
        }
    } catch (const Failure& failure) {
        throw yourself(failure.what());
    }
    throw yourself("no browser has signed in within a minute");
}

}    // namespace anoctl
