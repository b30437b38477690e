"""How the estimators cope with sensor errors, wrong nominal models and other plants."""
