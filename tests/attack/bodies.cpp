// Request bodies whose content differs from what they appear to be.
#include <support/token_gateway.hpp>

#include <thread>

namespace bodies_tests {
namespace {

using namespace support;

/// With a simulated flight controller.
class Bodies : public TokenGateway {
protected:
    Bodies() : TokenGateway{R"("sim:fc")"} {}

    /// The end of the upgrade job that a file starts, or the answer that starts none.
    nlohmann::json flashed(const std::string& file, const std::string& type = "application/octet-stream",
                           const std::string& query = {}) {
        const std::string answer = http(socket, "POST /devices/0xDC/firmware" + query + " HTTP/1.0\r\nContent-Type: " + type +
                                                    "\r\nContent-Length: " + std::to_string(file.size()) + "\r\n\r\n" + file);
        nlohmann::json json = nlohmann::json::parse(body_of(answer), nullptr, false);
        json["code"] = code_of(answer);
        while (json.value("state", "") == "running") {
            std::this_thread::sleep_for(std::chrono::milliseconds{50});
            json = nlohmann::json::parse(body_of(http(socket, "GET /jobs/" + json["id"].dump() + " HTTP/1.0\r\n\r\n")), nullptr,
                                         false);
            if (json.value("done", 0) > 0) json["state"] = "sends";
        }
        return json;
    }
};

std::string in_utf16(std::string_view text, std::size_t low) {
    std::string units;
    for (const char c : text) low == 0 ? units.append({c, '\0'}) : units.append({'\0', c});
    return units;
}

TEST_F(Bodies, only_plain_bytes_are_flashed) {
    const std::string file(2000, '\x01');
    const std::string form = "--b\r\nContent-Disposition: form-data; name=\"file\"\r\n\r\n" + file + "\r\n--b--\r\n";
    for (const std::string type :
         {"multipart/form-data; boundary=b", "application/json", "text/plain", "application/x-www-form-urlencoded"})
        EXPECT_EQ(flashed(form, type).at("code"), "415") << type;
    const nlohmann::json sent = flashed(file, "Application/Octet-Stream; x=1");
    EXPECT_FALSE(sent.contains("code") && sent["code"] == "415") << sent;
    EXPECT_EQ(code_at_socket("POST /devices/0xDC/firmware",
                             "Content-Type: application/octet-stream\r\nContent-Type: multipart/form-data; boundary=b\r\n", file),
              "400")
        << "which of two types is meant is not guessed";
}

TEST_F(Bodies, that_look_unlike_firmware_need_force) {
    const std::string rest(2000, '\0');
    const std::pair<std::string, std::string> files[] = {
        {":10010000214601360121470136007EFE09D2190140\n", "Intel HEX"},
        {"\x7F"
         "ELF\x01\x01\x01" +
             rest,
         "ELF"},
        {"PK\x03\x04" + rest, "ZIP"},
        {"UF2\nWQ]\x9E" + rest, "UF2"},
        {"\x1F\x8B\x08" + rest, "gzip"},
        {"S00F000068656C6C6F202020202000003C\r\nS9030000FC\r\n", "Motorola S-record"},
        {"<!doctype html><title>Not found</title>\n" + std::string(3000, 'x'), "web page"},
        {"\xEF\xBB\xBF:10010000214601360121470136007EFE09D2190140\r\n", "Intel HEX"},
        {"\r\n:10010000214601360121470136007EFE09D2190140\r\n", "Intel HEX"},
        {"--b\r\nContent-Disposition: form-data; name=\"file\"\r\n\r\n" + rest + "\r\n--b--\r\n", "form"},
        {"\xFF\xFE" + in_utf16("hello text file firmware", 0), "text"},
        {"\xFE\xFF" + in_utf16("hello text file firmware", 1), "text"},
        {in_utf16("hello text file firmware", 0), "text"},
        {std::string("\xFF\xFE\xFA\x56\xF6\x4E\xF4\x8B\x0E\x66", 10), "text"},
        {"\xE5\x9B\xBA\xE4\xBB\xB6\xE4\xB8\x8D\xE5\xAD\x98\xE5\x9C\xA8\n", "text"},
    };
    for (const auto& [file, name] : files) {
        const nlohmann::json job = flashed(file);
        EXPECT_EQ(job.value("status", 0), 422) << name << ' ' << job;
        const std::string error = job.value("error", "");
        EXPECT_NE(error.find(name), std::string::npos) << error;
        if (name == "ELF" || name == "Intel HEX" || name == "Motorola S-record") {
            EXPECT_NE(error.find("objcopy"), std::string::npos) << error;
        }
    }
    const nlohmann::json forced = flashed(files[0].first, "application/octet-stream", "?force");
    EXPECT_EQ(forced.value("error", "").find("Intel HEX"), std::string::npos) << forced;
}

TEST_F(Bodies, of_json_with_a_duplicate_key_too_deep_or_with_trailing_text_are_rejected) {
    const std::string json = "Content-Type: application/json\r\n";
    const std::string deep = std::string(40, '[') + std::string(40, ']');
    const std::pair<std::string, std::string> routes[] = {
        {"PUT /devices/0xDC/parameters/0", R"("value": 1)"},
        {"POST /devices/0xDC/apply", R"("A": 1)"},
        {"POST /devices/0xDC/actions", R"("action": "save")"},
        {"POST /devices/0xDC/commands/LAND", R"("values": [])"},
        {"POST /devices/0xDC/commands/by-cid", R"("cid": [16, 0, 5])"},
        {"PUT /devices/0xDC/waypoints", R"("waypoints": [])"},
        {"POST /devices/0xDC/calibration", R"("what": "compass")"},
        {"POST /gpio", R"("link": "fc")"},
        {"POST /send", R"("name": "heartbeat")"},
        {"POST /login", R"("token": "x")"},
        {"PUT /flexible", R"("flexible": [])"},
        {"POST /recordings", R"("name": "x")"},
    };
    for (const auto& [line, member] : routes) {
        const std::string one = "{" + member + "}";
        for (const std::string& body : {"{" + member + ", " + member + "}", one + " x", one + one,
                                        one + std::string(1, '\0') + "x", one + "/**/", R"({"deep": )" + deep + "}"})
            EXPECT_TRUE(code_at_socket(line, json, body).starts_with("4")) << line << ' ' << body;
        const std::string twice = http(socket, line + " HTTP/1.0\r\n" + json +
                                                   "Content-Length: " + std::to_string(2 * member.size() + 4) + "\r\n\r\n{" +
                                                   member + ", " + member + "}");
        EXPECT_NE(twice.find("is given twice"), std::string::npos) << line << ' ' << twice;
        const std::string too_deep = R"({"deep": )" + deep + "}";
        const std::string nested = http(
            socket, line + " HTTP/1.0\r\n" + json + "Content-Length: " + std::to_string(too_deep.size()) + "\r\n\r\n" + too_deep);
        EXPECT_NE(nested.find("nested deeper than 32 levels"), std::string::npos) << line << ' ' << nested;
    }
}

TEST_F(Bodies, that_are_not_empty_where_none_is_expected_are_rejected) {
    const std::string json = "Content-Type: application/json\r\n";
    const std::string deep = std::string(40, '[') + std::string(40, ']');
    for (const std::string line :
         {"POST /reload?dry_run", "POST /reload/confirm", "POST /logout", "POST /devices/scan", "POST /jobs/1/next",
          "DELETE /jobs/1", "DELETE /routes/0x33", "POST /recordings/x/end", "DELETE /recordings/x"}) {
        for (const std::string& body : {std::string{R"({"a": 1})"}, std::string{R"({"a": 1, "a": 2})"}, deep, std::string{"{} x"},
                                        std::string{"[]"}, std::string{"nonsense"}, std::string(100'000, ' ')})
            EXPECT_TRUE(code_at_socket(line, json, body).starts_with("4")) << line << ' ' << body.substr(0, 40);
        EXPECT_EQ(code_at_socket(line, json, "{\"dry_run\": true}"), "400") << line;
    }
    for (const char* const nothing : {"", "{}", " { }\r\n"}) {
        EXPECT_EQ(code_at_socket("POST /reload?dry_run", json, nothing), "200") << nothing;
        EXPECT_EQ(code_at_socket("POST /logout", json, nothing), "200") << nothing;
    }
}

}    // namespace
}    // namespace bodies_tests
