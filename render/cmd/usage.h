#pragma once
/// What is wrong with a command line, in one sentence: what was found, what was expected, the nearest valid
/// thing.
#include <CLI/CLI.hpp>

#include <string>
#include <utility>
#include <vector>

namespace cmd {

/// For Option::check(): whole numbers, or numbers, from least to most.
CLI::Validator whole_number(long least, long most);
CLI::Validator number_from(double least, double most);
/// For Option::transform(): a number > 0 and one of these units, "" among them, becomes the number in the first of them.
CLI::Validator quantity(std::vector<std::pair<std::string, double>> units);
/// For Option::check(): one of these words.
CLI::Validator one_of(std::vector<std::string> words);

/// The message of an error that parsing has thrown. argv: as given to main.
std::string usage_message(const CLI::App& app, int argc, char** argv, const CLI::ParseError& error);

} // namespace cmd
