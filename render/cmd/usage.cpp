#include "render/cmd/usage.h"

#include "sim/scene/tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace cmd {

namespace {

template <typename Number>
CLI::Validator number_between(Number least, Number most, const char* kind) {
    const auto check = [=](const std::string& text) {
        Number value{};
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool is_good =
            error == std::errc() && end == text.data() + text.size() && value >= least && value <= most;
        return is_good ? std::string() : fmt::format("'{}': expected {} {} to {}", text, kind, least, most);
    };
    return CLI::Validator(check, "");
}

bool is_option(std::string_view word) {
    return word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9');
}

std::vector<std::string> verbs_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
        names.push_back(verb->get_name());
    }
    return names;
}

std::vector<std::string> options_of(const CLI::App& verb) {
    std::vector<std::string> names;
    for (const CLI::Option* option : verb.get_options()) {
        for (const std::string& name : option->get_lnames()) {
            names.push_back("--" + name);
        }
    }
    return names;
}

std::string help_of(const std::string& verb) {
    return "; see tumble " + (verb.empty() ? std::string() : verb + " ") + "--help";
}

/// The first word that is no option of the verb.
std::string unknown_option(const CLI::App& verb, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        const std::string name = word.substr(0, word.find('='));
        if (is_option(name) && verb.get_option_no_throw(name) == nullptr) {
            return name;
        }
    }
    return "";
}

/// "WORD: ..." -> WORD.
std::string before_colon(const std::string& text) {
    return text.substr(0, text.find(':'));
}

} // namespace

CLI::Validator whole_number(long least, long most) {
    return number_between(least, most, "a whole number");
}

CLI::Validator number_from(double least, double most) {
    return number_between(least, most, "a number");
}

CLI::Validator quantity(std::vector<std::pair<std::string, double>> units) {
    const auto convert = [units = std::move(units)](std::string& text) {
        double value = 0.0;
        const char* const last = text.data() + text.size();
        const auto [end, error] = std::from_chars(text.data(), last, value);
        const auto unit = std::ranges::find(units, std::string(end, last), &std::pair<std::string, double>::first);
        if (error != std::errc() || !(value > 0.0) || !std::isfinite(value) || unit == units.end()) {
            std::vector<std::string> words;
            for (const auto& [word, factor] : units) {
                words.push_back(word);
            }
            return fmt::format("'{}': expected a number > 0 with one of the units {}, or {} without", text,
                               fmt::join(words.begin() + 1, words.end(), ", "), words[1]);
        }
        text = fmt::format("{}", value * unit->second);
        return std::string();
    };
    return CLI::Validator(convert, "");
}

CLI::Validator one_of(std::vector<std::string> words) {
    const auto check = [words = std::move(words)](const std::string& text) {
        const bool is_good = std::ranges::find(words, text) != words.end();
        return is_good ? std::string() : fmt::format("'{}': expected {}", text, fmt::join(words, ", "));
    };
    return CLI::Validator(check, "");
}

std::string usage_message(const CLI::App& app, int argc, char** argv, const CLI::ParseError& error) {
    const CLI::App* verb = &app;
    std::string path; // "baseline check"
    int next = 1;
    for (; !verbs_of(*verb).empty(); ++next) {
        const std::string space = path.empty() ? "" : path + ": ";
        if (next == argc) {
            return fmt::format("{}expected {}{}", space, fmt::join(verbs_of(*verb), " or "), help_of(path));
        }
        const std::string word = argv[next];
        if (is_option(word)) {
            return fmt::format("{}expected a verb before {}, such as {}{}", space, before_colon(word),
                               verbs_of(*verb).front(), help_of(path));
        }
        const auto verbs = verb->get_subcommands([&](const CLI::App* v) { return v->get_name() == word; });
        if (verbs.empty()) {
            return fmt::format("{}unknown verb '{}'{}{}", space, word, sim::suggestion(word, verbs_of(*verb)),
                               help_of(path));
        }
        verb = verbs.front();
        path += (path.empty() ? "" : " ") + word;
    }
    const std::vector<std::string> words(argv + next, argv + argc);
    const std::string what = error.what();
    const std::string unknown = unknown_option(*verb, words);
    if (!unknown.empty()) {
        return fmt::format("{} has no option '{}'{}{}", path, unknown, sim::near_miss(unknown, options_of(*verb)),
                           help_of(path));
    }
    if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) {
        return before_colon(what) + what.substr(std::min(what.size(), what.find(':') + 1)) + help_of(path);
    }
    const CLI::Option* option = verb->get_option_no_throw(before_colon(what));
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && option != nullptr) {
        const std::string name = option->get_name();
        const bool is_empty = what.find("missing") != std::string::npos;
        return is_empty
                   ? fmt::format("{}: no value, expected {}{}", name, option->get_type_name(), help_of(path))
                   : fmt::format("{} is given more than once{}", name, help_of(path));
    }
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
        return fmt::format("{}: {} is missing{}", path, what.substr(0, what.find(' ')), help_of(path));
    }
    const std::vector<std::string> extras = app.remaining(true);
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !extras.empty()) {
        return fmt::format("'{}' is one too many for {}{}", extras.front(), path, help_of(path));
    }
    return what + help_of(path);
}

} // namespace cmd
