"""What the certificate proves over s: kappa, following errors, and the error of the tool."""
