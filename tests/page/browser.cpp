#include "tests/page/browser.h"

#include "sim/base/base64.h"

#include <httplib.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace {

using Json = Browser::Json;

/// Starts chromedriver, which ends with this process; returns its id and the port that it has found free.
std::pair<int, int> start_driver(const std::filesystem::path& log) {
    int ends[2];
    if (pipe(ends) != 0) {
        throw std::runtime_error("pipe");
    }
    const int id = fork();
    if (id == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        const std::string log_option = "--log-path=" + log.string();
        execlp("chromedriver", "chromedriver", "--port=0", log_option.c_str(), static_cast<char*>(nullptr));
        _exit(127);
    }
    close(ends[1]);
    FILE* output = fdopen(ends[0], "r");
    int port = 0;
    char line[512];
    while (port == 0 && std::fgets(line, sizeof line, output) != nullptr) {
        const char* found = std::strstr(line, "successfully on port ");
        if (found != nullptr) {
            port = std::atoi(found + std::strlen("successfully on port "));
        }
    }
    std::fclose(output);
    if (port == 0) {
        throw std::runtime_error("chromedriver does not start; is chromium-driver installed?");
    }
    return {id, port};
}

Json pointer(const char* type, double x, double y, int duration = 0) {
    Json action = {{"type", type}, {"button", 0}};
    if (std::string_view(type) == "pointerMove") {
        action = {{"type", type}, {"x", std::lround(x)}, {"y", std::lround(y)}, {"duration", duration}};
    }
    return action;
}

Json mouse(const Json& actions) {
    return {{"type", "pointer"},
            {"id", "mouse"},
            {"parameters", {{"pointerType", "mouse"}}},
            {"actions", actions}};
}

} // namespace

Browser::Browser(const std::filesystem::path& folder) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const auto [driver, port] = start_driver(folder / "chromedriver.log");
    driver_ = driver;
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port);
    client_->set_keep_alive(true);
    client_->set_read_timeout(60);
    const Json arguments = Json::array(
        {"--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic",
         "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--disable-dev-shm-usage", "--hide-scrollbars", "--user-data-dir=" + (folder / "profile").string()});
    const Json answer = send("POST", "/session",
                             {{"capabilities",
                               {{"alwaysMatch",
                                 {{"browserName", "chrome"},
                                  {"goog:loggingPrefs", {{"browser", "ALL"}}},
                                  {"goog:chromeOptions", {{"args", arguments}}}}}}}});
    session_ = "/session/" + answer.at("sessionId").get<std::string>();
}

Browser::~Browser() {
    try {
        send("DELETE", session_);
    } catch (const std::exception&) {
        // The driver's end below takes the browser with it.
    }
    kill(driver_, SIGTERM);
    waitpid(driver_, nullptr, 0);
}

Json Browser::send(const char* method, const std::string& path, const Json& body) {
    const bool is_post = std::string_view(method) == "POST";
    const httplib::Result result = is_post ? client_->Post(path, body.dump(), "application/json")
                                   : std::string_view(method) == "GET" ? client_->Get(path)
                                                                       : client_->Delete(path);
    if (!result) {
        throw std::runtime_error("chromedriver: " + httplib::to_string(result.error()) + " at " + path);
    }
    const Json answer = Json::parse(result->body);
    if (result->status != 200) {
        throw std::runtime_error("chromedriver: " + answer.at("value").at("message").get<std::string>());
    }
    return answer.at("value");
}

void Browser::open(const std::string& url) {
    send("POST", session_ + "/url", {{"url", "about:blank"}});
    send("POST", session_ + "/url", {{"url", url}});
}

void Browser::resize(int width, int height, bool is_phone) {
    send("POST", session_ + "/goog/cdp/execute",
         {{"cmd", "Emulation.setDeviceMetricsOverride"},
          {"params",
           {{"width", width},
            {"height", height},
            {"deviceScaleFactor", is_phone ? 2 : 1},
            {"mobile", is_phone}}}});
    send("POST", session_ + "/goog/cdp/execute",
         {{"cmd", "Emulation.setTouchEmulationEnabled"},
          {"params", {{"enabled", is_phone}, {"maxTouchPoints", 5}}}});
}

void Browser::prefer(const std::string& scheme) {
    const Json feature = {{"name", "prefers-color-scheme"}, {"value", scheme}};
    send("POST", session_ + "/goog/cdp/execute",
         {{"cmd", "Emulation.setEmulatedMedia"}, {"params", {{"features", Json::array({feature})}}}});
}

Json Browser::value(const std::string& expression) {
    return send("POST", session_ + "/execute/sync",
                {{"script", "return " + expression + ";"}, {"args", Json::array()}});
}

bool Browser::wait_for(const std::string& expression) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (value("Boolean(" + expression + ")") != true) {
        if (std::chrono::steady_clock::now() > end) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
    }
    return true;
}

std::pair<double, double> Browser::corner(const std::string& selector) {
    const Json box =
        value("(e => { e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect();"
              " return [b.left, b.top]; })(document.querySelector(" +
              Json(selector).dump() + "))");
    return {box.at(0), box.at(1)};
}

void Browser::act(const Json& actions) {
    send("POST", session_ + "/actions", {{"actions", actions}});
    send("DELETE", session_ + "/actions");
}

void Browser::click(const std::string& selector) {
    const Json element =
        send("POST", session_ + "/element", {{"using", "css selector"}, {"value", selector}});
    send("POST", session_ + "/element/" + element.begin()->get<std::string>() + "/click");
}

void Browser::press(const std::string& key_text, bool with_shift) {
    Json actions = Json::array();
    const auto add = [&actions](const char* type, const std::string& value) {
        actions.push_back(Json{{"type", type}, {"value", value}});
    };
    if (with_shift) {
        add("keyDown", key::shift);
    }
    add("keyDown", key_text);
    add("keyUp", key_text);
    if (with_shift) {
        add("keyUp", key::shift);
    }
    const Json keyboard = {{"type", "key"}, {"id", "keyboard"}, {"actions", actions}};
    act(Json::array({keyboard}));
}

void Browser::type(const std::string& selector, const std::string& text) {
    const Json element =
        send("POST", session_ + "/element", {{"using", "css selector"}, {"value", selector}});
    const std::string path = session_ + "/element/" + element.begin()->get<std::string>();
    send("POST", path + "/clear");
    send("POST", path + "/value", {{"text", text}});
}

void Browser::move_to(const std::string& selector, double x, double y) {
    const auto [left, top] = corner(selector);
    act(Json::array({mouse(Json::array({pointer("pointerMove", left + x, top + y)}))}));
}

void Browser::click_at(const std::string& selector, double x, double y) {
    drag(selector, x, y, x, y);
}

void Browser::drag(const std::string& selector, double x, double y, double to_x, double to_y) {
    const auto [left, top] = corner(selector);
    act(Json::array({mouse(
        Json::array({pointer("pointerMove", left + x, top + y), pointer("pointerDown", 0, 0),
                     pointer("pointerMove", left + to_x, top + to_y, 60), pointer("pointerUp", 0, 0)}))}));
}

void Browser::scroll(const std::string& selector, double x, double y, int delta) {
    const auto [left, top] = corner(selector);
    const Json scrolled = {{"type", "scroll"},
                           {"x", std::lround(left + x)},
                           {"y", std::lround(top + y)},
                           {"deltaX", 0},
                           {"deltaY", delta}};
    const Json wheel = {{"type", "wheel"}, {"id", "wheel"}, {"actions", Json::array({scrolled})}};
    act(Json::array({wheel}));
}

void Browser::pinch(const std::string& selector, double x, double y, double spread, double to_spread) {
    const auto [left, top] = corner(selector);
    Json fingers = Json::array();
    for (const int side : {-1, 1}) {
        const double middle = left + x;
        const Json actions = Json::array({pointer("pointerMove", middle + side * spread / 2, top + y),
                                          pointer("pointerDown", 0, 0),
                                          pointer("pointerMove", middle + side * to_spread / 2, top + y, 100),
                                          pointer("pointerUp", 0, 0)});
        fingers.push_back(Json{{"type", "pointer"},
                               {"id", side < 0 ? "thumb" : "finger"},
                               {"parameters", {{"pointerType", "touch"}}},
                               {"actions", actions}});
    }
    act(fingers);
}

void Browser::screenshot(const std::filesystem::path& path) {
    std::ofstream(path, std::ios::binary)
        << sim::bytes_of_base64(send("GET", session_ + "/screenshot").get<std::string>()).value();
}

std::string Browser::errors() {
    std::string text;
    for (const Json& entry : send("POST", session_ + "/se/log", {{"type", "browser"}})) {
        if (entry.at("level") == "SEVERE") {
            text += entry.at("message").get<std::string>() + "\n";
        }
    }
    return text;
}
