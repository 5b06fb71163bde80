"""From recordings to a scene: fit(). recordings.py and bags.py read; problem.py simulates; solve.py fits; deviations.py, words.py, hints.py
and diagnosis.py judge; yaml_edit.py writes the scene; pictures.py draws."""
