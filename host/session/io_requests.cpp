#include "host/session/io_requests.hpp"

#include <chrono>
#include <filesystem>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

IoRequests::IoRequests(Conversation& conversation) : conversation_(conversation) {
    conversation_.handle(bus::Body::IoDone, [this](const bus::Message& message) {
        take(*message.as<schema::IoDone>());
    });
    for (const bus::Body kind : {bus::Body::MeshContent, bus::Body::ArchiveContent}) {
        conversation_.handle(kind, [this](const bus::Message& message) {
            if (message.kind() == content_kind_) {
                outcome_.content = message;
            }
        });
    }
}

void IoRequests::run(const std::string& what, ExitCode on_death, bus::Payload request,
                     const std::function<bool()>& done) {
    struct Release {
        MachinePort& machine;
        ~Release() { machine.release_io(); }
    };
    MachinePort& machine = conversation_.machine();
    machine.name_work(what);
    const bus::NodeId io = machine.start_io(on_death);
    const Release release{machine};
    is_done_ = false;
    outcome_ = {};
    content_kind_ = request.kind() == bus::Body::ReadArchive ? bus::Body::ArchiveContent
                                                             : bus::Body::MeshContent;
    machine.send(io, std::move(request));
    conversation_.wait(what, [&] { return done() || conversation_.has_fault(); });
}

IoOutcome IoRequests::read(const std::string& path, bus::Payload request, ExitCode on_death) {
    const Conversation::Cancelable cancelable(conversation_);
    run(path, on_death, std::move(request), [this] { return is_done_; });
    return std::exchange(outcome_, {});
}

IoOutcome IoRequests::write(const std::string& path, bus::Payload request) {
    remove_abandoned_parts(path);
    // File systems keep times in steps of up to 2 s.
    const auto start = std::filesystem::file_time_type::clock::now() - std::chrono::seconds(3);
    try {
        return read(path, std::move(request));
    } catch (...) {
        if (!is_done_) {
            remove_parts_of(path, start);  // A killed process cannot remove them.
        }
        throw;
    }
}

void IoRequests::take(const schema::IoDone& done) {
    is_done_ = true;
    outcome_.triangles = static_cast<std::int64_t>(done.triangles());
    outcome_.text = done.text() != nullptr ? done.text()->str() : "";
    if (!done.ok()) {
        throw IoFailure(done.bad_data() ? ExitCode::bad_data : ExitCode::failed,
                        done.error() ? done.error()->str() : "input or output failed");
    }
}

}  // namespace pxpl5::host
