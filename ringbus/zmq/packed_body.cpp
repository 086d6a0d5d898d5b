#include "ringbus/zmq/packed_body.hpp"

#include <fmt/core.h>
#include <zstd.h>

#include <stdexcept>

namespace pxpl5::bus {

namespace {

constexpr int fastest_level = 1;

}  // namespace

struct Packer::Context {
    ZSTD_CCtx* zstd = ZSTD_createCCtx();
    Context() = default;
    ~Context() { ZSTD_freeCCtx(zstd); }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
};

Packer::Packer() = default;
Packer::~Packer() = default;

std::optional<zmq::message_t> Packer::pack(std::span<const std::uint8_t> body) {
    if (!context_) {
        context_ = std::make_unique<Context>();
    }
    if (context_->zstd == nullptr) {
        return std::nullopt;  // Without memory to compress it, the body travels as it is.
    }
    const std::size_t most = body.size() - body.size() / 10;
    zmq::message_t packed(most);
    const std::size_t size = ZSTD_compressCCtx(context_->zstd, packed.data(), most, body.data(),
                                               body.size(), fastest_level);
    if (ZSTD_isError(size) != 0) {  // It has no room in `most`.
        return std::nullopt;
    }
    return zmq::message_t(packed.data(), size);
}

std::shared_ptr<zmq::message_t> unpacked_body(const schema::Header& header, const PackedBody& form,
                                              const zmq::message_t& packed) {
    const auto refuse = [&header](const std::string& what) -> BadMessage {
        return {header,
                fmt::format("message from node {}: a compressed body {}", header.source(), what)};
    };
    if (form.method != PackedBody().method) {
        throw refuse(fmt::format("has method {}, expected {}", form.method, PackedBody().method));
    }
    // The size is checked before memory is taken for it.
    const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (stated != header.body_bytes() || stated > max_body_bytes) {
        throw refuse(
            fmt::format("states a size of {} bytes, its header {}", stated, header.body_bytes()));
    }
    auto body = std::make_shared<zmq::message_t>(stated);
    const std::size_t size =
        ZSTD_decompress(body->data(), body->size(), packed.data(), packed.size());
    if (ZSTD_isError(size) != 0 || size != body->size()) {
        throw refuse(ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "is cut off");
    }
    return body;
}

}  // namespace pxpl5::bus
