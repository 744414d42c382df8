"""One page on a local web server."""

from __future__ import annotations

from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from neurframe_cli.errors import UsageError

HOST = "127.0.0.1"


def serve_page(page: str, port: int, ready: Callable[[str], None]) -> None:
    """Serves `page` at / on the loopback interface until the process is interrupted.

    port: 0 for any that is free; ready(address) is called once the server answers.  Raises UsageError where the port
    is taken, KeyboardInterrupt at the end.
    """
    content = page.encode()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self._answer(content)

        def do_HEAD(self) -> None:
            self._answer(b"")

        def _answer(self, body: bytes) -> None:
            # another site's name that leads to this machine must not read the page
            if self.path != "/" or self.headers.get("Host") not in _names(server):
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: Any) -> None:
            """Requests are nobody's news."""

    try:
        server = ThreadingHTTPServer((HOST, port), Handler)
    except OSError as error:
        raise UsageError(f"port {port} cannot be used: {error.strerror}", hint="another --port") from error
    with server:
        ready(f"http://{HOST}:{server.server_port}/")
        server.serve_forever()


def _names(server: ThreadingHTTPServer) -> tuple[str, str]:
    return f"{HOST}:{server.server_port}", f"localhost:{server.server_port}"
