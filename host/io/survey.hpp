// Questions about DICOM files that need no volume, each answered by a process of its own: the
// series of a folder, and the attributes of a file. The answer is lines of JSON.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/io/limits.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_surveyed_series = 200;
inline constexpr std::size_t max_thumbnails = 60;
inline constexpr double thumbnails_s = 10;  ///< No thumbnail is begun after this time.

struct SurveyQuestion {
    std::string name;    ///< --series or --attributes
    std::string path;    ///< A file or a folder.
    std::string series;  ///< UID of the series whose middle file --attributes reads.
};

struct SurveyLimits {
    std::vector<std::string> allowed;  ///< Folders to which links may lead, beside the folder.
    Limits limits;
    bool confines = true;
};

/// The question that `arguments` ask, the first being the program: --series PATH, or --attributes
/// PATH series=UID. The word keeps a UID from a file from being an option. Nothing if they are
/// other arguments.
std::optional<SurveyQuestion> take_survey(const std::vector<std::string>& arguments);

/// Writes the answer to standard output.
///
/// --series      {"series":[..],"more":N} with a row for each series, in the order of `series=N`,
///               but for the last N; then {"thumbnail":I,"width":W,"height":H,"pixels":HEX} for
///               each picture, as it is made; then {"done":true}.
/// --attributes  One object: {"file":NAME,"attributes":[[GROUP,ELEMENT,DEPTH,KEYWORD,VR,VALUE,
///               IS_CUT],..],"is_whole":B}
///
/// Returns the exit code: 0, or 65 with the reason on standard error.
int serve_survey(const SurveyQuestion& question, const SurveyLimits& limits);

}  // namespace pxpl5::host::io
