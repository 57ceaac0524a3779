#pragma once
/// The results of runs as one HTML page: films, posters, figures, plots, reports of comparisons.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace diff {

/// Energy of all bodies at one instant.
struct EnergySample {
    double time = 0.0;      ///< [s]
    double kinetic = 0.0;   ///< [J]
    double potential = 0.0; ///< [J]
};

/// One run. Paths are relative to the folder of the page; empty: there is none.
struct GalleryRun {
    std::string name;
    std::string title;
    std::string film;
    std::string poster;
    std::vector<std::pair<std::string, std::string>> facts; ///< name and value with its unit, in order
    std::vector<EnergySample> energy;                       ///< in order of time; below two: no plot
    std::vector<std::string> plots;                         ///< pictures beside the film
    std::string model;         ///< glTF, as `tumble export` writes it; model + ".js" is what model_script() makes of it
    std::vector<double> times; ///< [s] simulated, by tenths of a second of the film
    std::vector<std::string> files;                         ///< to be downloaded
};

/// The page of a comparison.
struct GalleryReport {
    std::string name;
    std::string page; ///< path
    std::int64_t cases = 0;
    std::int64_t failed = 0;
};

/// The page of a study.
struct GalleryStudy {
    std::string name;
    std::string page;    ///< path
    std::string diagram; ///< path; empty: there is none
};

struct Gallery {
    std::string program; ///< "tumble 0.1.0"
    std::vector<GalleryRun> runs;
    std::vector<GalleryReport> reports;
    std::vector<GalleryStudy> studies;
    std::vector<std::string> plots;                         ///< of no run
    std::vector<std::pair<std::string, std::string>> texts; ///< path, and what is written there
};

/// What a page that is read from a disk loads in place of the file: its path in the page's folder and its bytes.
std::string model_script(const std::string& path, const std::string& bytes);

/// index.html. Same results, same bytes.
std::string gallery_page(const Gallery& gallery);

} // namespace diff
