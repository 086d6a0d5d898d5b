// The open port of a web server, over libwebsockets.
#pragma once

#include <memory>
#include <string>

#include "host/serve/server/server_access.hpp"

struct lws_context;
struct lws_protocols;
struct lws_protocol_vhost_options;

namespace pxpl5::host::serve {

/// Listens at the address of the options, with their encryption, and with limits of the memory for
/// connections and heads.
class Listener {
  public:
    /// protocols       End with an empty one. They must live as long as this object.
    /// content_policy  Value of Content-Security-Policy in every answer; a literal.
    /// user            What lws_context_user() returns. Callbacks come during this call, too.
    /// Throws as Server does.
    Listener(const ServerOptions& options, const lws_protocols* protocols,
             const char* content_policy, void* user);
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    lws_context* context() const { return context_; }
    int port() const { return port_; }
    /// Has new tokens, and the names by which this port is reached.
    const AccessRules& rules() const { return rules_; }
    /// "http://127.0.0.1:4711/", to be opened with a token.
    std::string address() const;

  private:
    void listen(const ServerOptions& options, const lws_protocols* protocols, void* user);

    std::unique_ptr<lws_protocol_vhost_options> policy_;
    AccessRules rules_;
    lws_context* context_ = nullptr;
    std::string host_;
    int port_ = 0;
};

}  // namespace pxpl5::host::serve
