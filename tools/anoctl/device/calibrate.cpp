// anoctl calibrate: calibrates a sensor while the user turns the device.
#include "calibration_text.hpp"
#include "device_client.hpp"
#include "job_view.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/terminal.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

class CalibrationView final : public JobView {
public:
    CalibrationView(Streams& streams, bool yes) : streams_{streams}, yes_{yes}, lines_{streams.err} {}

    void show(const Json& job) override {
        const std::string message = text_at(job, "message");
        const bool waits = text_at(job, "state") == "waiting";
        if (streams_.err_is_terminal) {
            std::vector<std::string> lines = calibration_lines(job);
            lines.push_back(message + (waits ? " (Enter continues, Ctrl-C cancels)" : ""));
            const std::size_t width = Screen::size().width;
            return lines_.show(broken_lines(lines, width), width);
        }
        for (const auto& [text, last_printed] : {std::pair{message, &message_}, {calibration_step(job), &step_}})
            if (!text.empty() && text != std::exchange(*last_printed, text)) print_note(streams_, text);
    }
    void end() override { lines_.clear(); }
    void went_down(std::size_t lines) override { lines_.went_down(lines); }
    bool continues_unattended() const override { return yes_ || !streams_.in_is_terminal; }

private:
    Streams& streams_;
    const bool yes_;
    LiveLines lines_;
    std::string message_, step_;    // last printed
};

struct Calibrate {
    DeviceOptions options;
    std::string what;

    int run(Streams& streams) const {
        DeviceClient client{options, streams};
        client.will_act();
        client.must_be_able_to_ask("calibrate");
        const char* todo = what == "compass" ? "need to rotate it slowly in all directions, away from magnetic metal"
                                             : "need to place it on each of its six faces and keep it still";
        if (!client.may("Calibrate the " + what + " of " + client.device_words() + "? You " + todo + ".")) {
            print_note(streams, "nothing was changed");
            return failed;
        }
        anogate::http::Request request;
        request.method = "POST";
        request.target = client.target("/calibration");
        request.body = Json{{"what", what}}.dump();
        CalibrationView view{streams, options.yes};
        const Json result = client.run(std::move(request), view);
        if (options.json) streams.out << ano::json_text(result) << '\n';
        else
            for (const std::string& line : calibration_result(result, what)) print(streams, line);
        return fine;
    }
};

}    // namespace

Run add_calibrate(Options& options) {
    const auto self = std::make_shared<Calibrate>();
    const auto read_what = [self](const std::string& word) -> std::string {
        if (word != "accelerometer" && word != "compass") return ano::in_quotes(word) + " is not accelerometer or compass";
        self->what = word;
        return {};
    };
    options.push_back({"what", Option::Read{read_what}, "accelerometer|compass",
                       "Sensor to calibrate. Shows the remaining steps; restores the old calibration if you cancel or if the new "
                       "one is not better",
                       true});
    DeviceOptions::add(options, self->options, "calibrate");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
