"""How wrong a result is: known answers, an independent judge, error against speed."""
