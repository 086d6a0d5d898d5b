#include "host/serve/server/routes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/base/error.hpp"

namespace pxpl5::host::serve {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_page_files = 1000;
constexpr std::string_view download_folder = "/download/";

struct FileType {
    std::string_view extension, type;
};

// A file of another kind in the page's folder (its README, say) is not served.
constexpr std::array<FileType, 8> page_types{{{".html", "text/html; charset=utf-8"},
                                              {".js", "text/javascript; charset=utf-8"},
                                              {".css", "text/css; charset=utf-8"},
                                              {".map", "application/json"},
                                              {".svg", "image/svg+xml"},
                                              {".png", "image/png"},
                                              {".ico", "image/x-icon"},
                                              {".webmanifest", "application/manifest+json"}}};

std::string_view type_of(const fs::path& path) {
    const std::string extension = path.extension().string();
    const auto* found = std::ranges::find(page_types, extension, &FileType::extension);
    return found == page_types.end() ? std::string_view{} : found->type;
}

RequestError missing(const fs::path& path) {
    return {ExitCode::bad_data, fmt::format("cannot serve the page: {} is missing", path.string())};
}

/// A name that can only be a file in the folder itself.
bool is_plain_name(std::string_view name) {
    const auto is_odd = [](char c) {
        return c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ';
    };
    return !name.empty() && name.front() != '.' && std::ranges::none_of(name, is_odd);
}

}  // namespace

Routes::Routes(RouteFolders folders) : downloads_(std::move(folders.downloads)) {
    add_files(folders.page, false);
    if (!folders.bundle.empty()) {
        add_files(folders.bundle, true);
    }
    const auto index = files_.find("/index.html");
    index->second.is_page = true;
    files_["/"] = index->second;
}

void Routes::add_files(const fs::path& folder, bool is_bundle) {
    if (!fs::is_directory(folder)) {
        throw missing(folder);
    }
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string_view type = type_of(entry.path());
        if (type.empty() || entry.is_symlink() || !entry.is_regular_file()) {
            continue;
        }
        const std::string name = "/" + entry.path().lexically_relative(folder).string();
        files_[name] = {entry.path(), std::string(type), "", false, is_bundle};
        if (files_.size() > max_page_files) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("cannot serve the page: {} contains more than {} files",
                                           folder.string(), max_page_files));
        }
    }
    if (!fs::is_regular_file(folder / "index.html")) {
        throw missing(folder / "index.html");
    }
}

Route Routes::find(std::string_view path) const {
    if (path == "/socket") {
        return {RouteKind::socket, {}};
    }
    if (path == "/upload") {
        return {RouteKind::upload, {}};
    }
    if (path == "/upload/files") {
        return {RouteKind::upload_files, {}};
    }
    if (path == "/upload/done") {
        return {RouteKind::upload_done, {}};
    }
    if (const auto found = files_.find(path); found != files_.end()) {
        return {RouteKind::file, found->second};
    }
    if (!path.starts_with(download_folder) || !is_plain_name(path.substr(download_folder.size()))) {
        return {};
    }
    const std::string name(path.substr(download_folder.size()));
    const fs::path file = downloads_ / name;
    std::error_code error;
    // A link could lead out of the folder, so it is not followed.
    if (!fs::is_regular_file(fs::symlink_status(file, error))) {
        return {RouteKind::none, {}, true};
    }
    return {RouteKind::file, {file, "application/octet-stream", name}, true};
}

Route Routes::find(std::string_view path, int port) const {
    Route route = find(path);
    const std::string part = fmt::format("/{}", port);
    std::size_t at = route.kind == RouteKind::none ? 0 : std::string_view::npos;
    while ((at = path.find(part, at)) != std::string_view::npos) {
        at += part.size();
        if (at == path.size()) {
            return {RouteKind::slash, {}};
        }
        if (path[at] == '/') {
            return find(path.substr(at));
        }
    }
    return route;
}

RouteFolders built_in_folders() {
    return {PXPL5_PAGE_FOLDER, PXPL5_BUNDLE_FOLDER, ""};
}

}  // namespace pxpl5::host::serve
