#pragma once
/// Chromium without a window, driven through chromedriver as a person would: keys, mouse, fingers.
/// Protocol: W3C WebDriver (https://www.w3.org/TR/webdriver2/).
#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace httplib {
class Client;
}

/// Key codes of WebDriver, sec. 17.4.2, in UTF-8.
namespace key {
inline constexpr const char* shift = "\uE008";
inline constexpr const char* escape = "\uE00C";
inline constexpr const char* left = "\uE012";
inline constexpr const char* right = "\uE014";
inline constexpr const char* down = "\uE015";
} // namespace key

class Browser {
public:
    using Json = nlohmann::json;

    /// Starts driver and browser with an empty profile in `folder`. Throws std::runtime_error.
    explicit Browser(const std::filesystem::path& folder);
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    void open(const std::string& url);
    /// Window of width x height [px]; a phone has touch and no mouse.
    void resize(int width, int height, bool is_phone = false);
    /// prefers-color-scheme: "light" or "dark".
    void prefer(const std::string& scheme);

    /// The value of a JavaScript expression.
    Json value(const std::string& expression);
    /// Waits up to 20 s until the expression is true; false if it never is.
    bool wait_for(const std::string& expression);

    void click(const std::string& selector);
    /// Presses and releases a key, with Shift held if asked for.
    void press(const std::string& key, bool with_shift = false);
    void type(const std::string& selector, const std::string& text);
    /// Mouse positions [px] are from the upper left corner of the element.
    void move_to(const std::string& selector, double x, double y);
    void click_at(const std::string& selector, double x, double y);
    void drag(const std::string& selector, double x, double y, double to_x, double to_y);
    void scroll(const std::string& selector, double x, double y, int delta);
    /// Two fingers move apart from `spread` to `to_spread` [px] around a point.
    void pinch(const std::string& selector, double x, double y, double spread, double to_spread);

    /// Writes what is visible as a PNG file.
    void screenshot(const std::filesystem::path& path);
    /// What the page has complained about since the last call, one message a line.
    std::string errors();

private:
    Json send(const char* method, const std::string& path, const Json& body = Json::object());
    void act(const Json& actions);
    std::pair<double, double> corner(const std::string& selector);

    int driver_ = -1; // process id
    std::unique_ptr<httplib::Client> client_;
    std::string session_;
};
