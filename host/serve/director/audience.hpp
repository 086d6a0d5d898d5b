// The director's view of the web server, which a test can replace.
#pragma once

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

/// The functions of Server that a director calls; Server describes them.
class Audience {
  public:
    virtual ~Audience() = default;
    virtual int event_fd() const = 0;
    virtual std::vector<Event> take() = 0;
    virtual void send(std::uint32_t viewer, std::string text) = 0;
    virtual void send_binary(std::uint32_t viewer, std::string bytes) = 0;
    virtual void opened(std::string path) = 0;
    virtual void show(Shown frame) = 0;
    virtual void wear(std::uint32_t viewer, std::size_t pair_pixels) = 0;
    virtual bool wants_frame() const = 0;
    virtual bool wants_pair() const = 0;
    virtual LinkAdvice advice() const = 0;
};

/// The server's viewers.
class WebAudience final : public Audience {
  public:
    explicit WebAudience(Server& server) : server_(server) {}
    int event_fd() const override { return server_.event_fd(); }
    std::vector<Event> take() override { return server_.take(); }
    void send(std::uint32_t viewer, std::string text) override {
        server_.send(viewer, std::move(text));
    }
    void send_binary(std::uint32_t viewer, std::string bytes) override {
        server_.send_binary(viewer, std::move(bytes));
    }
    void opened(std::string path) override { server_.opened(std::move(path)); }
    void show(Shown frame) override { server_.show(std::move(frame)); }
    void wear(std::uint32_t viewer, std::size_t pair_pixels) override {
        server_.wear(viewer, pair_pixels);
    }
    bool wants_frame() const override { return server_.wants_frame(); }
    bool wants_pair() const override { return server_.wants_pair(); }
    LinkAdvice advice() const override { return server_.advice(); }

  private:
    Server& server_;
};

}  // namespace pxpl5::host::serve
