#include "host/serve/director/file_access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"

namespace pxpl5::host::serve {

namespace {

namespace fs = std::filesystem;

/// The path without links, as far as it exists.
fs::path real_path(const fs::path& path) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(fs::absolute(path), error);
    return error ? fs::path() : real;
}

bool is_hidden(const fs::path& name) {
    return name.native().starts_with('.');
}

bool is_within(const fs::path& folder, const fs::path& path) {
    return std::ranges::mismatch(folder, path).in1 == folder.end();
}

/// True if a name of the path below the folder begins with a dot: keys, start-up files, settings.
bool is_hidden_within(const fs::path& folder, const fs::path& path) {
    return std::any_of(std::ranges::mismatch(folder, path).in2, path.end(), is_hidden);
}

[[noreturn]] void refuse_path(std::string_view who, const std::string& path,
                              const std::string& reason) {
    refuse_command(fmt::format("{}: {} {}", who, path, reason));
}

/// The files that are there under a name with any number for "{}".
std::vector<fs::path> numbered_files(const fs::path& pattern) {
    const std::string name = pattern.filename().string();
    const std::size_t number = name.find("{}");
    if (number == std::string::npos) {
        return {};
    }
    const std::string begin = name.substr(0, number), end = name.substr(number + 2);
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator at(pattern.parent_path(), error);
         !error && at != fs::directory_iterator(); at.increment(error)) {
        const std::string other = at->path().filename().string();
        if (other.size() > begin.size() + end.size() && other.starts_with(begin) &&
            other.ends_with(end)) {
            files.push_back(at->path());
        }
    }
    return files;
}

/// All files that the command may write for this word: itself, files of this pattern that are
/// there, and files beside it.
std::vector<fs::path> written_files(const CommandDescriptor& command, const std::string& path) {
    const fs::path file = fs::absolute(path);
    std::vector<fs::path> files = numbered_files(file);
    files.insert(files.begin(), file);
    if (command.files_beside != nullptr) {
        std::ranges::move(command.files_beside(file.string()), std::back_inserter(files));
    }
    return files;
}

/// A built-in volume is no file.
bool is_built_in(const std::string& source) {
    return source.starts_with("phantom:");
}

/// A machine of `model` is a file only if it looks like one: the others have names.
bool is_path(const CommandDescriptor& command, const std::string& word) {
    return command.name != "model" || word.find_first_of("/.") != std::string::npos;
}

/// `certificate` takes names of surfaces and files of meshes.
bool may_be_mesh_file(const CommandDescriptor& command, const std::string& word) {
    return command.name == "certificate" && word.find('.') != std::string::npos;
}

}  // namespace

FileAccess::FileAccess(fs::path downloads, std::vector<fs::path> others, std::vector<fs::path> own)
    : downloads_(real_path(downloads)) {
    folders_.push_back(downloads_);
    for (const fs::path& folder : others) {
        folders_.push_back(real_path(folder));
    }
    own_.push_back(downloads_);
    for (const fs::path& folder : own) {
        own_.push_back(real_path(folder));
        folders_.push_back(own_.back());
    }
    std::erase(folders_, fs::path());
}

void FileAccess::allow_volume(const std::string& source) {
    if (is_built_in(source)) {
        return;
    }
    const fs::path real = real_path(source);
    if (real.empty()) {
        return;  // An empty path would be the beginning of every path.
    }
    folders_.push_back(real);  // The volume itself may be hidden.
    std::error_code error;
    if (!fs::is_directory(real, error)) {
        folders_.push_back(real.parent_path());
    }
}

FileAccess::Place FileAccess::place_of(const fs::path& real) const {
    Place place = Place::outside;
    for (const fs::path& folder : folders_) {
        if (!real.empty() && is_within(folder, real)) {
            if (!is_hidden_within(folder, real)) {
                return Place::allowed;
            }
            place = Place::hidden;
        }
    }
    return place;
}

void FileAccess::check(const CommandDescriptor& command, const Arguments& arguments) const {
    for (std::size_t i = 0; i < arguments.words.size(); ++i) {
        const std::string& word = arguments.words[i];
        const ValueType type = i < command.words.size() ? command.words[i].type : ValueType::text;
        if (type == ValueType::output) {
            for (const fs::path& file : written_files(command, word)) {
                check_write(command, file);
            }
        } else if ((type == ValueType::file && is_path(command, word)) ||
                   may_be_mesh_file(command, word)) {
            check_read(command.name, word);
        }
    }
}

void FileAccess::check_read(std::string_view who, const std::string& path) const {
    const Place place = is_built_in(path) ? Place::allowed : place_of(real_path(path));
    if (place == Place::hidden) {
        refuse_path(who, path,
                    "is a hidden file or in a hidden folder, which the browser may not read. Start "
                    "serve with --allow and the hidden folder, or upload the file");
    }
    if (place == Place::outside) {
        refuse_path(who, path,
                    "is outside of the folders that the browser may read: the volume's, uploads, "
                    "downloads and those of --allow. Start serve with --allow DIR, or upload the "
                    "file");
    }
}

bool FileAccess::may_read(const fs::path& path) const {
    return place_of(real_path(path)) == Place::allowed;
}

std::vector<fs::path> FileAccess::roots() const {
    std::vector<fs::path> roots;
    for (const fs::path& folder : folders_) {
        const auto holds = [&folder](const fs::path& other) { return is_within(other, folder); };
        std::error_code error;
        if (std::ranges::count(own_, folder) > 0 || std::ranges::any_of(roots, holds) ||
            !fs::is_directory(folder, error)) {
            continue;
        }
        std::erase_if(roots, [&folder](const fs::path& root) { return is_within(folder, root); });
        roots.push_back(folder);
    }
    return roots;
}

void FileAccess::check_write(const CommandDescriptor& command, const fs::path& file) const {
    const std::string path = file.string();
    const fs::path folder = real_path(file.parent_path());
    const fs::path real = real_path(host::place_of(file));  // A link's target may not exist yet.
    std::error_code unknown;
    const Place place = std::max(place_of(real), place_of(folder));
    if (place == Place::outside) {
        refuse_path(command.name, path,
                    "is outside of the folders that the browser may write: the volume's, uploads, "
                    "downloads and those of --allow. Write download:NAME, start serve with --allow "
                    "DIR, or run the command in the terminal");
    }
    if (is_hidden(file.filename()) || is_hidden(real.filename())) {
        refuse_path(command.name, path,
                    "is a hidden file, which the browser may not write. Choose a name without a "
                    "dot at its begin");
    }
    if (place == Place::hidden) {
        refuse_path(command.name, path,
                    "is in a hidden folder, which the browser may not write. Write download:NAME, "
                    "start serve with --allow and the hidden folder, or run the command in the "
                    "terminal");
    }
    if (!is_within(downloads_, real) &&
        fs::exists(fs::symlink_status(folder / file.filename(), unknown))) {
        refuse_path(command.name, path,
                    "exists already, and the browser does not replace files beside downloads. "
                    "Choose another name, or write download:NAME");
    }
}

}  // namespace pxpl5::host::serve
