#include "host/report/sources.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

namespace pxpl5::host::report {

namespace {

namespace fs = std::filesystem;

/// "pelvis/skin" of "phantom:pelvis", "ct-knee/skin" of "ct/knee_128x128x56.nrrd".
std::string name_of(const timing::PaperRow& row) {
    std::string volume(row.volume.substr(row.volume.find(':') + 1));
    std::ranges::replace(volume, '/', '-');
    return fmt::format("{}/{}", volume.substr(0, volume.find('_')), row.surface);
}

void check_names(const std::vector<Source>& all, std::span<const std::string> names,
                 bool has_data) {
    std::vector<std::string_view> known;
    for (const Source& source : all) {
        known.push_back(source.name);
    }
    for (const std::string& name : names) {
        if (std::ranges::find(known, name) == known.end()) {
            throw RequestError(ExitCode::usage,
                               fmt::format("no row '{}'{}{}", name, did_you_mean(name, known),
                                           has_data ? "" : "; --data FOLDER adds more"));
        }
    }
}

void check_files(const std::vector<Source>& sources, const std::string& folder) {
    for (const Source& source : sources) {
        if (!source.row.volume.starts_with("phantom:") && !fs::is_regular_file(source.volume)) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("--data {}: '{}', which row {} needs, is not there",
                                           folder, source.row.volume, source.name));
        }
    }
}

}  // namespace

std::vector<Source> sources_of(const std::string& data_folder, std::span<const std::string> names) {
    const bool has_data = !data_folder.empty();
    if (has_data && !fs::is_directory(data_folder)) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("--data {}: there is no such folder", data_folder));
    }
    std::vector<Source> sources;
    for (const timing::PaperRow& row : timing::paper_rows()) {
        sources.push_back({row, name_of(row), std::string(row.volume)});
    }
    for (const timing::PaperRow& row : timing::data_rows()) {
        if (has_data) {
            sources.push_back({row, name_of(row), (fs::path(data_folder) / row.volume).string()});
        }
    }
    check_names(sources, names, has_data);
    std::erase_if(sources, [names](const Source& source) {
        return !names.empty() && std::ranges::find(names, source.name) == names.end();
    });
    check_files(sources, data_folder);
    return sources;
}

}  // namespace pxpl5::host::report
