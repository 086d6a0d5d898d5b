#include "host/io/survey.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/thumbnail.hpp"
#include "host/io/import.hpp"
#include "host/io/request_needs.hpp"

namespace pxpl5::host::io {

namespace {

using Json = nlohmann::ordered_json;
using Series = std::vector<DicomSlice>;

constexpr std::string_view list_series = "--series", list_attributes = "--attributes";

constexpr std::size_t max_list_bytes = 400 << 10;  ///< Leaves room for the thumbnails.

std::string dump(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The host sees each line as soon as it is written: a decoder may end the process later.
void write_line(const Json& line) {
    const std::string text = dump(line) + "\n";
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
        std::fflush(stdout) != 0) {
        throw ImportError(fmt::format(
            "the host took only a part of the {} bytes of a line of the answer", text.size()));
    }
}

/// "Doe^Jane" as "Doe, Jane".
std::string person(std::string name) {
    name = name.substr(0, name.find('='));  // Other writings of the name follow.
    if (const std::size_t caret = name.find('^'); caret != std::string::npos) {
        name.replace(caret, 1, ", ");
    }
    std::ranges::replace(name, '^', ' ');
    const std::size_t last = name.find_last_not_of(", ");
    return last == std::string::npos ? "" : name.substr(0, last + 1);
}

/// Center and width of the slice's preferred window; nothing if it has none.
std::optional<std::pair<double, double>> window_of(const DicomSlice& slice) {
    return slice.windows.empty()
               ? std::nullopt
               : std::optional(std::pair(slice.windows.front().level, slice.windows.front().width));
}

std::uint64_t bytes_of_files(const Series& series) {
    std::set<std::filesystem::path> counted;
    std::uint64_t bytes = 0;
    for (const DicomSlice& slice : series) {
        bytes += counted.insert(slice.path).second ? slice.facts.size_bytes : 0;
    }
    return bytes;
}

/// A series, and what its thumbnail needs.
struct Surveyed {
    DicomSlice middle;
    DicomAttributes attributes;
};

/// None if they cannot be read: the series remains in the list.
DicomAttributes attributes_or_none(const DicomInput& file) {
    try {
        return read_attributes(file);
    } catch (const ImportError&) {
        return {};
    } catch (const std::bad_alloc&) {
        return {};
    }
}

Json row_of(std::size_t number, const Series& series, const Surveyed& surveyed) {
    const DicomAttributes& a = surveyed.attributes;
    const DicomSlice& first = series.front();
    const std::string series_date = a.value(0x0008, 0x0021);
    return {{"number", number},
            {"uid", first.series},
            {"patient", person(a.value(0x0010, 0x0010))},
            {"patient_id", a.value(0x0010, 0x0020)},
            {"study", a.value(0x0020, 0x000d)},
            {"study_date", a.value(0x0008, 0x0020)},
            {"study_description", a.value(0x0008, 0x1030)},
            {"description", a.value(0x0008, 0x103e)},
            {"series_number", first.series_number},
            {"modality", a.value(0x0008, 0x0060)},
            {"body_part", a.value(0x0018, 0x0015)},
            {"date", series_date.empty() ? a.value(0x0008, 0x0020) : series_date},
            {"columns", first.columns},
            {"rows", first.rows},
            {"slices", series.size()},
            {"bytes", bytes_of_files(series)}};
}

std::string hex_of(const std::vector<std::uint8_t>& bytes) {
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}

void write_thumbnails(const std::vector<Surveyed>& all) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < std::min(all.size(), max_thumbnails); ++i) {
        if (Clock::now() - start > std::chrono::duration<double>(thumbnails_s)) {
            return;
        }
        Thumbnail picture;
        try {
            picture = thumbnail_of(all[i].middle, window_of(all[i].middle));
        } catch (const ImportError&) {
            continue;  // The row stays without a picture; opening the series gives the reason.
        } catch (const std::bad_alloc&) {
            continue;
        }
        write_line({{"thumbnail", i},
                    {"width", picture.width},
                    {"height", picture.height},
                    {"pixels", hex_of(picture.pixels)}});
    }
}

void write_series(std::vector<DicomSlice> slices) {
    const std::vector<Series> all = series_of(std::move(slices));
    Json rows = Json::array();
    std::vector<Surveyed> surveyed;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < std::min(all.size(), max_surveyed_series); ++i) {
        const DicomSlice middle = middle_of(all[i]);
        Surveyed each{middle, attributes_or_none(middle.input())};
        Json row = row_of(i + 1, all[i], each);
        bytes += dump(row).size();
        if (bytes > max_list_bytes) {
            break;
        }
        rows.push_back(std::move(row));
        surveyed.push_back(std::move(each));
    }
    write_line({{"series", rows}, {"more", all.size() - rows.size()}});
    write_thumbnails(surveyed);
    write_line({{"done", true}});
}

void write_attributes(const SurveyQuestion& question, std::vector<DicomSlice> slices) {
    const std::vector<Series> all = series_of(std::move(slices));
    const auto is_wanted = [&](const Series& series) {
        return series.front().series == question.series;
    };
    const auto found = std::ranges::find_if(all, is_wanted);
    if (found == all.end()) {
        throw ImportError(question.path + ": holds no DICOM slices" +
                          (question.series.empty() ? "" : " of series " + question.series));
    }
    if (question.series.empty() && std::ranges::count_if(all, is_wanted) > 1) {
        throw ImportError(question.path +
                          ": holds several series without a UID (0020,000e). Open a folder or "
                          "file of one of them");
    }
    const DicomSlice middle = middle_of(*found);
    const DicomAttributes attributes = read_attributes(middle.input());
    Json rows = Json::array();
    for (const DicomAttribute& each : attributes.all) {
        rows.push_back(
            {each.group, each.element, each.depth, each.keyword, each.vr, each.value, each.is_cut});
    }
    write_line(
        {{"file", middle.path.string()}, {"attributes", rows}, {"is_whole", attributes.is_whole}});
}

}  // namespace

std::optional<SurveyQuestion> take_survey(const std::vector<std::string>& arguments) {
    constexpr std::string_view before_uid = "series=";
    if (arguments.size() == 3 && arguments[1] == list_series) {
        return SurveyQuestion{arguments[1], arguments[2], ""};
    }
    if (arguments.size() == 4 && arguments[1] == list_attributes &&
        arguments[3].starts_with(before_uid)) {
        return SurveyQuestion{arguments[1], arguments[2], arguments[3].substr(before_uid.size())};
    }
    return std::nullopt;
}

int serve_survey(const SurveyQuestion& question, const SurveyLimits& limits) {
    constexpr int bad_data = 65;
    constexpr unsigned most_s = 90;  // Above the limit of the server, which may be killed.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    alarm(most_s);
    std::string reason;
    try {
        limit_next_request(limits.limits);
        if (limits.confines) {
            confine(needs_of_survey(question.path, limits.allowed));
        }
        std::vector<DicomSlice> slices = find_slices(question.path, limits.allowed);
        if (question.name == list_series) {
            write_series(std::move(slices));
        } else {
            write_attributes(question, std::move(slices));
        }
        return 0;
    } catch (const std::bad_alloc&) {
        reason = question.path + ": does not fit in the memory that the io process may use";
    } catch (const std::filesystem::filesystem_error& error) {
        reason = fmt::format("{}: {}", question.path, error.code().message());
    } catch (const std::exception& error) {
        reason = error.what();
    }
    std::fprintf(stderr, "%s\n", reason.c_str());
    return bad_data;
}

}  // namespace pxpl5::host::io
