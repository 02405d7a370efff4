"""Run the command line as `python -m eyehand.apps`."""

from .main import main

main()
