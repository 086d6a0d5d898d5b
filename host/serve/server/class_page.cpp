#include "host/serve/server/class_page.hpp"

#include <fmt/format.h>
#include <libwebsockets.h>

#include <array>
#include <atomic>
#include <charconv>
#include <thread>
#include <vector>

#include "host/base/kernel/signals_blocked.hpp"
#include "host/serve/server/listener.hpp"
#include "host/serve/server/server_request.hpp"
#include "host/serve/server/strangers.hpp"
#include "host/serve/texts/class_texts.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr const char* content_policy =
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";
constexpr const char* html = "text/html; charset=utf-8";
constexpr std::string_view style =
    "body{margin:0;min-height:100vh;display:grid;place-items:center;background:#14181d;"
    "color:#e6e9ed;font:16px/1.5 system-ui,sans-serif}"
    "main{max-width:32rem;padding:1.5rem}h1{font-size:1.5rem;margin:0 0 .5rem}"
    "p{margin:0;overflow-wrap:anywhere}";

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '<':
                result += "&lt;";
                break;
            case '&':
                result += "&amp;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

/// The part of a Host header before the port: "lab1", "[::1]".
std::string_view without_port(std::string_view host) {
    return host.starts_with('[') ? host.substr(0, host.find(']') + 1)
                                 : host.substr(0, host.find(':'));
}

/// Whether Host and Origin allow the request, whatever secret it shows.
Verdict judge_source(const AccessRules& rules, Request request) {
    request.query["token"] = rules.driver_token;
    return judge(rules, request);
}

/// The language that the address asks for; empty if it asks for none.
std::string_view asked_by(const Request& request) {
    const auto found = request.query.find("lang");
    return found == request.query.end() ? std::string_view{} : found->second;
}

/// The same as a part of the address of a session: "&lang=de".
std::string asked_language(const Request& request) {
    const std::string_view asked = asked_by(request);
    return asked.empty() ? "" : "&lang=" + language_of(asked, "");
}

}  // namespace

int last_port_in(std::string_view path) {
    if (!path.ends_with('/') || path.size() < 3) {
        return 0;
    }
    path.remove_suffix(1);
    const std::string_view last = path.substr(path.rfind('/') + 1);
    constexpr int most = 65535;
    int port = 0;
    const auto [end, error] = std::from_chars(last.data(), last.data() + last.size(), port);
    return error == std::errc{} && end == last.data() + last.size() && port > 0 && port <= most
               ? port
               : 0;
}

std::string page_text(const PageAnswer& answer, std::string_view language) {
    const std::string heading = escaped(text_in(answer.heading, language));
    std::string sentence = escaped(text_in(answer.sentence, language));
    if (!answer.why.empty()) {
        const bool is_said = has_text(answer.why, language);
        const std::string why = escaped(text_in({answer.why}, language));
        sentence =
            fmt::format("{}{}{}", is_said ? why : fmt::format("<span lang=\"en\">{}</span>", why),
                        sentence.empty() ? "" : " ", sentence);
    }
    return fmt::format(
        "<!doctype html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\">"
        "<meta name=\"viewport\" content=\"width=device-width\">{}<title>{}</title>"
        "<style>{}</style></head>\n<body><main><h1>{}</h1><p>{}</p></main></body></html>\n",
        language,
        answer.again_s == 0
            ? ""
            : fmt::format("<meta http-equiv=\"refresh\" content=\"{}\">", answer.again_s),
        heading, style, heading, sentence);
}

class ClassPage::Core {
  public:
    Core(const ServerOptions& options, ClassAnswers& answers)
        : answers_(answers), listener_(options, protocols.data(), content_policy, this) {
        const SignalsBlocked blocked;
        thread_ = std::thread([this] {
            while (!stopping_ && lws_service(listener_.context(), 0) >= 0) {
            }
            if (!stopping_) {
                answers_.fail();
            }
        });
    }
    ~Core() {
        stopping_ = true;
        lws_cancel_service(listener_.context());
        thread_.join();
    }
    Core(const Core&) = delete;
    Core& operator=(const Core&) = delete;

    const Listener& listener() const { return listener_; }

  private:
    static int on_call(lws* connection, lws_callback_reasons reason, void* user, void* data,
                       std::size_t size);
    int on_event(lws* connection, int reason);
    int on_request(lws* connection);
    int send(lws* connection, const Request& request, const PageAnswer& reply) const;
    /// Sends a browser that has asked for another port, seen from this one, to it.
    int pass_on(lws* connection, const Request& request, int port) const;

    static const std::array<lws_protocols, 2> protocols;

    ClassAnswers& answers_;
    Strangers strangers_;
    std::atomic<bool> stopping_ = false;
    Listener listener_;  ///< Its callbacks use the members above.
    std::thread thread_;
};

const std::array<lws_protocols, 2> ClassPage::Core::protocols{
    {{"pxpl5-class", on_call, 0, 0, 0, nullptr, 0}, {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};

int ClassPage::Core::on_call(lws* connection, lws_callback_reasons reason, void* /*user*/,
                             void* /*data*/, std::size_t /*size*/) {
    lws_context* context = lws_get_context(connection);
    auto* core = context == nullptr ? nullptr : static_cast<Core*>(lws_context_user(context));
    // Nothing may be thrown through libwebsockets: a connection that cannot be served is closed.
    try {
        return core == nullptr ? 0 : core->on_event(connection, reason);
    } catch (const std::exception&) {
        return -1;
    }
}

int ClassPage::Core::on_event(lws* connection, int reason) {
    switch (reason) {
        case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
            strangers_.meet(connection);
            return 0;
        case LWS_CALLBACK_TIMER:
            return strangers_.has(connection) ? -1 : 0;
        case LWS_CALLBACK_WSI_DESTROY:
            strangers_.forget(connection);
            return 0;
        case LWS_CALLBACK_HTTP:
            return on_request(connection);
        case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
            return -1;  // The sessions have the WebSockets.
        default:
            return 0;
    }
}

int ClassPage::Core::on_request(lws* connection) {
    const Request request = read_request(connection);
    const AccessRules& rules = listener_.rules();
    if (const Verdict source = judge_source(rules, request); source.status != 200) {
        PageAnswer answer{source.status, {class_text::not_known}, {}};
        answer.why = source.reason;
        return send(connection, request, answer);
    }
    if (request.method != "GET" || !request.path.ends_with('/')) {
        return send(connection, request,
                    {404, {class_text::no_such_page}, {class_text::with_slash}});
    }
    const int port = last_port_in(request.path);
    if (port != 0 && port != listener_.port() && answers_.has_port(port)) {
        return pass_on(connection, request, port);
    }
    Request with_cookie = request;
    with_cookie.query.clear();
    // The cookie counts before the token, so that the same browser gets the same session again.
    PageAnswer answer = answers_.answer_known([&](const std::string& secret) {
        AccessRules of_browser = rules;
        of_browser.driver_session = secret;
        return judge(of_browser, with_cookie).status == 200;
    });
    if (answer.status == 0) {
        if (judge(rules, request).status != 200) {
            return send(connection, request,
                        {403, {class_text::not_complete}, {class_text::with_token}});
        }
        answer = answers_.answer_new();
    }
    strangers_.accept(connection);
    return send(connection, request, answer);
}

int ClassPage::Core::send(lws* connection, const Request& request, const PageAnswer& reply) const {
    if (reply.port != 0) {
        // From the place of this server's own port, which a portal may have in its path.
        return redirect(connection, fmt::format("../{}/?token={}{}", reply.port, reply.token,
                                                asked_language(request)));
    }
    // Lax: a browser shows the cookie also when it follows a link to this page.
    const std::string cookie =
        reply.secret.empty()
            ? ""
            : fmt::format("{}={}; HttpOnly; SameSite=Lax{}", listener_.rules().cookie_name,
                          reply.secret, listener_.rules().encrypted ? "; Secure" : "");
    std::vector<Header> headers;
    if (!cookie.empty()) {
        headers.push_back({WSI_TOKEN_HTTP_SET_COOKIE, cookie});
    }
    const std::string language =
        language_of(asked_by(request), header_of(connection, WSI_TOKEN_HTTP_ACCEPT_LANGUAGE));
    const int kept = answer(connection, reply.status, html, page_text(reply, language), headers);
    return reply.status == 200 ? kept : -1;
}

int ClassPage::Core::pass_on(lws* connection, const Request& request, int port) const {
    const auto token = request.query.find("token");
    constexpr std::string_view digits = "0123456789abcdef";
    if (token == request.query.end() ||
        token->second.find_first_not_of(digits) != std::string::npos) {
        return send(connection, request,
                    {403, {class_text::not_complete}, {class_text::open_again}});
    }
    return redirect(
        connection,
        fmt::format("{}://{}:{}/?token={}{}", listener_.rules().encrypted ? "https" : "http",
                    without_port(request.host), port, token->second, asked_language(request)));
}

ClassPage::ClassPage(const ServerOptions& options, ClassAnswers& answers)
    : core_(std::make_unique<Core>(options, answers)) {}
ClassPage::~ClassPage() = default;

std::string ClassPage::url() const {
    return core_->listener().address() + "?token=" + core_->listener().rules().driver_token;
}
int ClassPage::port() const {
    return core_->listener().port();
}

}  // namespace pxpl5::host::serve
