// The one table of what is served at which path, and from where.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace pxpl5::host::serve {

/// A file to be sent.
struct ServedFile {
    std::filesystem::path path;
    std::string type;        ///< Content-Type.
    std::string attachment;  ///< Name to save it under; empty: to be shown.
    bool is_page = false;    ///< The page itself, which gives a browser its cookie.
    /// Part of the bundle, whose addresses on the page change with its bytes ("main.js?v=HASH").
    bool is_bundled = false;
};

/// The handling of a request's path.
enum class RouteKind : std::uint8_t {
    none,
    file,
    socket,
    upload,
    upload_files,
    upload_done,
    slash  ///< The page, but without the slash from which its files have their addresses.
};

struct Route {
    RouteKind kind = RouteKind::none;
    ServedFile file;           ///< If kind is file.
    bool is_download = false;  ///< The path names a download, which may not exist.
};

struct RouteFolders {
    std::filesystem::path page;       ///< Holds index.html and everything it names.
    std::filesystem::path bundle;     ///< Its files replace those of the page; empty: none.
    std::filesystem::path downloads;  ///< Looked into at each request.
};

/// A request's path names a row of a table, never a place in the file system.
class Routes {
  public:
    /// Lists the page's files. Throws RequestError (bad_data) naming a file that is missing.
    explicit Routes(RouteFolders folders);

    /// path  Of the request: decoded, with its leading '/', without the query.
    Route find(std::string_view path) const;

    /// The same for a path that may have a prefix, because a portal has not removed it. Portals
    /// name the port of this server last: "/node/n1/4711/main.js".
    Route find(std::string_view path, int port) const;

  private:
    void add_files(const std::filesystem::path& folder, bool is_bundle);

    std::filesystem::path downloads_;
    std::map<std::string, ServedFile, std::less<>> files_;
};

/// The folders of the page's files and of its bundle, as built in.
RouteFolders built_in_folders();

}  // namespace pxpl5::host::serve
