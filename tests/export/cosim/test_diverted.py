"""What foreign code prints goes to standard error."""

import ctypes
import os

from wmr_ctrl.export.cosim.diverted import diverted


def test_python_and_c_print_elsewhere_until_the_last_has_left(capfd):
    library = ctypes.CDLL(None)
    print("before")
    with diverted():
        print("python")
        with diverted():
            os.write(1, b"system\n")
        library.puts(b"library")
    print("after")
    library.fflush(None)
    out, err = capfd.readouterr()

    assert out.split() == ["before", "after"]
    assert {"python", "system", "library"} <= set(err.split())
