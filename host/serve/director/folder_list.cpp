#include "host/serve/director/folder_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "host/base/error.hpp"

namespace pxpl5::host::serve {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Question {
    std::string path, find;
    bool all = false;
};

struct Entry {
    fs::path path;
    std::string name;
    bool is_folder = false;
    const char* kind = "";  ///< The format that the name of a file promises; empty for others.
};

struct Kind {
    std::string_view suffix;
    const char* name;
};

/// How names of volumes end. `load` looks at the contents, so this only chooses what is listed.
constexpr std::array kinds = {
    Kind{".nii", "NIfTI"},      Kind{".nii.gz", "NIfTI"},     Kind{".nrrd", "NRRD"},
    Kind{".nhdr", "NRRD"},      Kind{".mha", "MetaImage"},    Kind{".mhd", "MetaImage"},
    Kind{".vtk", "VTK"},        Kind{".hdr", "NIfTI header"}, Kind{".hdr.gz", "NIfTI header"},
    Kind{".dcm", "DICOM"},      Kind{".ima", "DICOM"},        Kind{".dicom", "DICOM"},
    Kind{".tif", "TIFF"},       Kind{".tiff", "TIFF"},        Kind{".png", "PNG"},
    Kind{".jpg", "JPEG"},       Kind{".jpeg", "JPEG"},        Kind{".bmp", "BMP"},
    Kind{".mgh", "FreeSurfer"}, Kind{".mgz", "FreeSurfer"},   Kind{".mgh.gz", "FreeSurfer"},
    Kind{".vti", "VTK"},        Kind{".phigs", "archive"},    Kind{".zip", "ZIP"},
    Kind{".tar", "tar"},        Kind{".tgz", "tar"},          Kind{".tar.gz", "tar"},
    Kind{".tbz2", "tar"},       Kind{".tar.bz2", "tar"},      Kind{".txz", "tar"},
    Kind{".tar.xz", "tar"},     Kind{".tzst", "tar"},         Kind{".tar.zst", "tar"},
};

std::string in_small(std::string text) {
    for (char& c : text) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return text;
}

/// The format that the name promises; empty for a name that looks like no volume. DICOM files often
/// have no suffix.
const char* kind_of_name(const std::string& name) {
    const std::string small = in_small(name);
    for (const Kind& kind : kinds) {
        if (small.ends_with(kind.suffix)) {
            return kind.name;
        }
    }
    return name.find('.') == std::string::npos ? "no suffix" : "";
}

/// JSON has no other texts.
bool is_utf8(const std::string& text) {
    try {
        (void)Json(text).dump();
        return true;
    } catch (const Json::type_error&) {
        return false;
    }
}

Question read_question(std::string_view message) {
    const Json ask = Json::parse(message, nullptr, false);
    const auto refuse = [](const char* key, const char* may_be) {
        refuse_command(fmt::format("ask folder: '{}' must be {}", key, may_be));
    };
    Question question;
    if (!ask.is_object() || !ask.contains("path") || !ask["path"].is_string()) {
        refuse("path", "the path of a folder, or \"\" for the allowed folders");
    }
    question.path = ask["path"].get<std::string>();
    if (question.path.find('\0') != std::string::npos) {
        refuse("path", "a text without a character of code 0");
    }
    if (ask.contains("find")) {
        if (!ask["find"].is_string()) {
            refuse("find", "a part of a name");
        }
        question.find = in_small(ask["find"].get<std::string>());
    }
    if (ask.contains("all")) {
        if (!ask["all"].is_boolean()) {
            refuse("all", "true or false");
        }
        question.all = ask["all"].get<bool>();
    }
    return question;
}

/// The entries of a folder that the question asks for, and how many others there are.
struct Contents {
    std::vector<Entry> entries;
    std::size_t read = 0;
    std::size_t other_files = 0;  ///< Names that look like no volume.
    std::size_t links_out = 0;    ///< Links to places that the browser may not read.
    std::size_t odd_names = 0;    ///< Names that are no UTF-8 text.
    bool is_whole = true;         ///< All entries were looked at.
};

void add(const FileAccess& access, const Question& question, const fs::directory_entry& found,
         Contents& contents) {
    const std::string name = found.path().filename().string();
    if (name.starts_with('.') || in_small(name).find(question.find) == std::string::npos) {
        return;
    }
    std::error_code error;
    // Only links lead out: the folder itself may be read, and the name is not hidden.
    if (found.is_symlink(error) && !access.may_read(found.path())) {
        ++contents.links_out;
        return;
    }
    const bool is_folder = found.is_directory(error);
    if (!is_folder && !found.is_regular_file(error)) {
        return;
    }
    if (!is_utf8(name)) {
        ++contents.odd_names;
        return;
    }
    const char* kind = is_folder ? "" : kind_of_name(name);
    if (!is_folder && *kind == '\0' && !question.all) {
        ++contents.other_files;
        return;
    }
    contents.entries.push_back({found.path(), name, is_folder, kind});
}

Contents read_folder(const FileAccess& access, const Question& question) {
    access.check_read("ask folder", question.path);
    std::error_code error;
    const fs::path folder = fs::canonical(question.path, error);
    if (error || !fs::is_directory(folder, error)) {
        refuse_command(fmt::format("ask folder: {} is no folder{}", question.path,
                                   error ? fmt::format(": {}", error.message()) : ""));
    }
    // The path as it was asked for may have another meaning: built-in volumes have paths, too.
    access.check_read("ask folder", folder.string());
    Contents contents;
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) {
        if (contents.read == max_read) {
            contents.is_whole = false;
            break;
        }
        ++contents.read;
        add(access, question, *at, contents);
    }
    if (error) {
        refuse_command(
            fmt::format("ask folder: {} cannot be read: {}", question.path, error.message()));
    }
    std::ranges::sort(contents.entries, [](const Entry& a, const Entry& b) {
        return a.is_folder != b.is_folder ? a.is_folder
                                          : strverscmp(a.name.c_str(), b.name.c_str()) < 0;
    });
    return contents;
}

/// Seconds since 1970.
Json modified_s(const fs::path& path) {
    std::error_code error;
    const fs::file_time_type time = fs::last_write_time(path, error);
    if (error) {
        return nullptr;
    }
    const auto since = std::chrono::file_clock::to_sys(time).time_since_epoch();
    return std::chrono::duration_cast<std::chrono::seconds>(since).count();
}

Json json_of(const Entry& entry) {
    std::error_code error;
    const std::uintmax_t bytes = entry.is_folder ? 0 : fs::file_size(entry.path, error);
    return {{"name", entry.name},
            {"path", entry.path.string()},
            {"is_folder", entry.is_folder},
            {"kind", entry.kind},
            {"bytes", entry.is_folder || error ? Json(nullptr) : Json(bytes)},
            {"modified_s", modified_s(entry.path)}};
}

/// The folder above; "" if that is the list of allowed folders.
std::string folder_above(const FileAccess& access, const fs::path& folder) {
    const fs::path above = folder.parent_path();
    return above != folder && access.may_read(above) ? above.string() : "";
}

Json roots_json(const FileAccess& access) {
    Json entries = Json::array();
    for (const fs::path& root : access.roots()) {
        if (is_utf8(root.string())) {
            entries.push_back(json_of({root, root.string(), true}));
        }
    }
    return {{"path", ""},       {"above", nullptr}, {"entries", entries}, {"more", 0},
            {"other_files", 0}, {"links_out", 0},   {"odd_names", 0},     {"is_whole", true}};
}

}  // namespace

bool asks_for_folder(std::string_view message) {
    const Json ask = Json::parse(message, nullptr, false);
    return ask.is_object() && ask.contains("ask") && ask["ask"] == "folder";
}

std::string list_folder(const FileAccess& access, std::string_view message) {
    const Question question = read_question(message);
    if (question.path.empty()) {
        return roots_json(access).dump();
    }
    const Contents contents = read_folder(access, question);
    const std::size_t shown = std::min(contents.entries.size(), max_listed);
    const fs::path folder = fs::canonical(question.path);
    Json entries = Json::array();
    for (std::size_t i = 0; i < shown; ++i) {
        entries.push_back(json_of(contents.entries[i]));
    }
    const Json json = {{"path", folder.string()},
                       {"above", folder_above(access, folder)},
                       {"entries", entries},
                       {"more", contents.entries.size() - shown},
                       {"other_files", contents.other_files},
                       {"links_out", contents.links_out},
                       {"odd_names", contents.odd_names},
                       {"is_whole", contents.is_whole}};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace pxpl5::host::serve
