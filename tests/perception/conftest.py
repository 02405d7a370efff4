"""Make the synthetic scenes of this folder importable in its subfolders."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
