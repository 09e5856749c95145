"""Kernels that share their imports are like others: own folder and environment, own end."""

import os
import time

import pytest
from jupyter_client.manager import start_new_kernel

pytestmark = pytest.mark.usefixtures("shared_kernels")
ABOUT = "import os, sys; print(os.getpid(), os.getcwd(), os.environ['WORD'], *sys.modules)"


@pytest.fixture
def kernel(tmp_path):
    manager, client = start_new_kernel(cwd=str(tmp_path), env=os.environ | {"WORD": "said"})
    yield manager, client
    client.stop_channels()
    manager.shutdown_kernel(now=True)


def printed(client, code):
    said = []
    reply = client.execute_interactive(
        code, timeout=60, output_hook=lambda message: said.append(message["content"].get("text"))
    )
    assert reply["content"]["status"] == "ok"
    return "".join(filter(None, said)).split()


def gone(pid):
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def test_kernel_has_its_own_folder_and_environment_and_others_imports(kernel, tmp_path):
    pid, folder, word, *modules = printed(kernel[1], ABOUT)
    assert (folder, word) == (str(tmp_path), "said") and int(pid) != os.getpid()
    assert {"matplotlib.pyplot", "pyvista", "scipy.integrate"} <= set(modules)
    assert not any(name.startswith("tunneller_lib") for name in modules)


def test_kernel_ends_with_the_process_that_asked_for_it(kernel):
    manager, client = kernel
    pid = int(printed(client, ABOUT)[0])
    os.kill(manager.provisioner.pid, 9)
    assert gone(pid)
