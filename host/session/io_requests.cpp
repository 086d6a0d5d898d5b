#include "host/session/io_requests.hpp"

#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

IoRequests::IoRequests(Conversation& conversation) : conversation_(conversation) {
    conversation_.handle(bus::Body::IoDone, [this](const bus::Message& message) {
        take(*message.as<schema::IoDone>());
    });
}

void IoRequests::run(const std::string& what, ExitCode on_death, bus::Payload request,
                     const std::function<bool()>& done) {
    struct Release {
        MachinePort& machine;
        ~Release() { machine.release_io(); }
    };
    MachinePort& machine = conversation_.machine();
    const bus::NodeId io = machine.start_io(on_death);
    const Release release{machine};
    is_done_ = false;
    machine.send(io, std::move(request));
    conversation_.wait(what, [&] { return done() || conversation_.has_fault(); });
}

IoOutcome IoRequests::write(const std::string& path, bus::Payload request) {
    run(path, ExitCode::failed, std::move(request), [this] { return is_done_; });
    return outcome_;
}

void IoRequests::take(const schema::IoDone& done) {
    is_done_ = true;
    outcome_ = {static_cast<std::int64_t>(done.triangles()),
                done.text() != nullptr ? done.text()->str() : ""};
    if (!done.ok()) {
        throw RequestError(done.bad_data() ? ExitCode::bad_data : ExitCode::failed,
                           done.error() ? done.error()->str() : "input or output failed");
    }
}

}  // namespace pxpl5::host
