"""What tests of linkages share."""

from __future__ import annotations

import shutil
import socket
from collections.abc import Iterator

import pytest
from linkage.browser import Browser


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if shutil.which("chromium") is None or shutil.which("chromedriver") is None:
        pytest.skip("there is no Chromium on this machine")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    found = Browser(port, tmp_path_factory.mktemp("profile"))
    yield found
    found.close()
