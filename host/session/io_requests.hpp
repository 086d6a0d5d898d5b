// Requests to the io process, which reads volumes and writes pictures and meshes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/session/conversation.hpp"

namespace pxpl5::host {

/// The report of the io process about a finished request.
struct IoOutcome {
    std::int64_t triangles = 0;
    std::string text;
    std::optional<bus::Message> content;  ///< MeshContent, or ArchiveContent of ReadArchive.
};

class IoRequests {
  public:
    explicit IoRequests(Conversation& conversation);

    /// Starts the io process, sends `request`, waits until `done`, and releases the process.
    /// Throws RequestError if the process fails or dies (then with the code `on_death`).
    void run(const std::string& what, ExitCode on_death, bus::Payload request,
             const std::function<bool()>& done);
    /// Waits until the io process reports the end of `request`. Throws as run().
    IoOutcome read(const std::string& path, bus::Payload request,
                   ExitCode on_death = ExitCode::failed);
    /// The same. Removes the unfinished files of `path` if the io process dies.
    IoOutcome write(const std::string& path, bus::Payload request);

  private:
    void take(const bus::schema::IoDone& done);

    Conversation& conversation_;
    bool is_done_ = false;
    bus::Body content_kind_ = bus::Body::NONE;  ///< The kind that the request has.
    IoOutcome outcome_;
};

}  // namespace pxpl5::host
