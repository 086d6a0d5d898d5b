// What a session does with files: volumes in, pictures out, by the io process.
#include <fmt/core.h>

#include <filesystem>
#include <stdexcept>

#include "host/digest.hpp"
#include "host/error.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session.hpp"
#include "host/stopwatch.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

void Session::with_io(const std::string& what, ExitCode on_death, bus::Payload request,
                      const std::function<bool()>& done) {
    struct Release {
        MachinePort& machine;
        ~Release() { machine.release_io(); }
    };
    const bus::NodeId io = machine_.start_io(on_death);
    const Release release{machine_};
    io_done_ = false;
    received_.reset();
    receiver_.reset();
    machine_.send(io, std::move(request));
    wait(what, [&] { return done() || fault_.has_value(); });
}

Volume Session::read(const std::string& source) {
    if (phigs::is_archive(source)) {
        throw RequestError(ExitCode::usage, source + " is a scene, not a volume");
    }
    if (is_phantom(source)) {
        try {
            Volume volume = make_phantom(source);
            Digest digest;
            digest.add(volume.values);
            volume.digest = digest.value();
            volume.source = source;
            return volume;
        } catch (const std::invalid_argument& error) {
            throw RequestError(ExitCode::usage, error.what());
        }
    }
    schema::ImportVolumeT request;
    request.path = source;
    with_io(source, ExitCode::bad_data, bus::pack(request),
            [this] { return received_.has_value(); });
    received_->source = std::filesystem::absolute(source).string();
    return std::move(*received_);
}

void Session::begin_volume_request() {
    memory_bytes_ = 0;
    begin_request([this](const bus::Message& message) {
        const auto* ready = message.as<schema::VolumeReady>();
        if (ready == nullptr || ready->volume() != volume_id_) {
            return false;
        }
        memory_bytes_ += static_cast<std::int64_t>(ready->memory_bytes());
        return true;
    });
}

LoadReport Session::load(const std::string& source) {
    if (phigs::is_archive(source)) {
        return load_archive(source);
    }
    LoadReport report{source};
    std::int64_t start_ns = now_ns();
    Volume volume = read(source);
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    scene.surfaces.clear();
    reports_.clear();
    region_costs_.clear();
    archive_.reset();
    volume_ = std::move(volume);
    ++volume_id_;
    begin_volume_request();
    const std::vector<bus::NodeId>& gps = machine_.gp_ids();
    const bus::Payload header = volume_header(*volume_, volume_id_);
    for (std::size_t i = 0; i < gps.size(); ++i) {
        machine_.send(gps[i], header);
        for_each_slice_batch_of_gp(
            *volume_, volume_id_, static_cast<int>(i), static_cast<int>(gps.size()),
            [&](bus::Payload batch) { machine_.send(gps[i], std::move(batch)); });
        machine_.send(gps[i], bus::pack(schema::VolumeEndT{{}, volume_id_}));
    }
    try {
        wait_for_gps(source);
    } catch (const RequestError&) {
        volume_.reset();  // A GP could not hold its share: nothing is loaded.
        throw;
    }
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

void Session::export_picture(const Picture& picture, const std::string& path,
                             const std::string& description) {
    flatbuffers::FlatBufferBuilder builder(picture.rgba.size() * 4 + 1024);
    const auto rgba = builder.CreateVector(
        reinterpret_cast<const std::uint8_t*>(picture.rgba.data()), picture.rgba.size() * 4);
    const auto path_text = builder.CreateString(path);
    const auto description_text = builder.CreateString(description);
    with_io(path, ExitCode::failed,
            bus::finish(builder,
                        schema::CreateExportPicture(
                            builder, path_text, static_cast<std::uint32_t>(picture.width),
                            static_cast<std::uint32_t>(picture.height), rgba, description_text)),
            [this] { return io_done_; });
}

}  // namespace pxpl5::host
