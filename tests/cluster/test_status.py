"""What ``alight cluster status`` says, without a cluster."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from types import SimpleNamespace

import pytest

from alight.cluster.status import dashboard_of


class Page(BaseHTTPRequestHandler):
    """Answers with the code that the path names."""

    def do_GET(self):
        self.send_response(int(self.path[1:]))
        self.end_headers()

    def log_message(self, *words):
        pass


@pytest.fixture(scope="module")
def port():
    with HTTPServer(("127.0.0.1", 0), Page) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,)).start()
        yield server.server_port
        server.shutdown()


def client_of(link, services=("dashboard",)):
    return SimpleNamespace(
        scheduler_info=lambda n_workers: {"services": dict.fromkeys(services, 0)},
        dashboard_link=link,
    )


@pytest.mark.parametrize(("code", "is_told"), [(200, True), (500, True), (404, False)])
def test_a_web_server_without_a_dashboard_is_none(port, code, is_told):
    link = f"http://127.0.0.1:{port}/{code}"
    assert dashboard_of(client_of(link)) == (link if is_told else None)


def test_a_dashboard_out_of_reach_is_told_and_one_that_is_not_there_is_not(port):
    assert dashboard_of(client_of("http://127.0.0.1:1/status")) == "http://127.0.0.1:1/status"
    assert dashboard_of(client_of("http://127.0.0.1:1/status", services=())) is None
